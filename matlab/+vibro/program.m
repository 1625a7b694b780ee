function path = program(path)
% VIBRO.PROGRAM  The command line program that all functions of this package call.
%
%   vibro.program                       the program's path or name
%   vibro.program('/opt/vibro/vibro')   use this program from now on
%
% Without a path, the environment variable VIBRO_PROGRAM is used. Without this variable, the program
% is "vibro" on the search path of the system.
  persistent chosen
  if nargin > 0
    path = vibro.inner.text(path, 'path of the program');
    if exist(path, 'file') ~= 2
      error('vibro:program', '%s: no such file; expected the path of the program vibro', path);
    end
    chosen = path;
  elseif ~isempty(chosen)
    path = chosen;
  else
    path = getenv('VIBRO_PROGRAM');
    if isempty(path)
      path = 'vibro';
    end
  end
end
