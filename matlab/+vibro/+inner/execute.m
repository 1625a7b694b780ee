function [said, notes] = execute(words)
% Runs the program with these arguments. `said` is its standard output, `notes` its standard error.
% A refusal or a failure of the program is an error with the program's own words.
  program = vibro.program();
  remedy = ['give its path with vibro.program(''/path/to/vibro'') or in the environment ', ...
            'variable VIBRO_PROGRAM'];
  if any(program == '/' | program == filesep) && exist(program, 'file') ~= 2
    error('vibro:program', 'the program %s is missing: %s', program, remedy);
  end
  errors = tempname();
  remover = onCleanup(@() vibro.inner.forget(errors));
  line = strjoin(cellfun(@vibro.inner.quoted, [{program}, words], 'UniformOutput', false), ' ');
  line = [line, ' 2> ', vibro.inner.quoted(errors)];
  if ispc
    % The shell of Windows removes the first and the last quotation mark of a line that begins with one.
    line = ['cd . && ', line];
  end
  [status, said] = system(line);
  notes = '';
  if exist(errors, 'file') == 2
    notes = strtrim(fileread(errors));
  end
  said = strtrim(said);
  if status == 0
    return
  end
  if any(status == [126, 127, 9009])
    error('vibro:program', 'the program %s cannot be run (%s): %s', program, notes, remedy);
  end
  kinds = {'vibro:failed', 'vibro:refused'};
  kind = kinds{1 + (status == 2)};
  if status == 130
    kind = 'vibro:interrupted';
  end
  if isempty(notes)
    notes = sprintf('the program ended with exit code %d', status);
  end
  error(kind, '%s', regexprep(notes, '^error: ', ''));
end
