/** The script of the worker, put in by the bundler. */
declare const WORKER: string;
