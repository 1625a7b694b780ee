function name = file(name)
% Name of a machine's file as an argument of the program, which must not look like an option.
  name = vibro.inner.text(name, 'the machine''s file');
  if isempty(name)
    error('vibro:refused', 'the machine''s file has an empty name; expected a file such as ''damper.toml''');
  end
  if name(1) == '-'
    name = ['.', filesep, name];
  end
end
