/** The worker's script, inserted by the bundler. */
declare const WORKER: string;
