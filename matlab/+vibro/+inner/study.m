function found = study(command, file, varargin)
% Runs a command for a machine's file and reads all tables of the folder of its results. Without the
% option 'out' the folder is temporary.
  [words, out] = vibro.inner.options(varargin);
  file = vibro.inner.file(file);
  kept = ~isempty(out);
  if ~kept
    out = tempname();
    remover = onCleanup(@() vibro.inner.forget(out));
  end
  [said, notes] = vibro.inner.execute([{command, file}, words, {['--out=', out]}]);
  if ~isempty(notes)
    warning('vibro:note', '%s', notes);
  end
  found = vibro.inner.tables(out);
  found.command = command;
  found.said = said;
  if kept
    found.folder = out;
  end
end
