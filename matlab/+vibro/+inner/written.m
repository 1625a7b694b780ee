function said = written(command, file, varargin)
% Runs a command whose result is its text or the files that it writes.
  [words, out] = vibro.inner.options(varargin);
  if ~isempty(out)
    words{end + 1} = ['--out=', out];
  end
  [said, notes] = vibro.inner.execute([{command, vibro.inner.file(file)}, words]);
  if ~isempty(notes)
    warning('vibro:note', '%s', notes);
  end
end
