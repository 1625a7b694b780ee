function said = new(name, file)
% VIBRO.NEW  Write the file of a machine of the gallery as a starting point
%
%   disp(vibro.new())                                  list the machines
%   vibro.new('damper_with_buffer');                   write damper_with_buffer.toml
%   vibro.new('damper_with_buffer', 'damper.toml');    write damper.toml
  words = {'new'};
  if nargin > 0
    words{end + 1} = vibro.inner.text(name, 'name of a machine');
  end
  if nargin > 1
    words{end + 1} = vibro.inner.file(file);
  end
  said = vibro.inner.execute(words);
end
