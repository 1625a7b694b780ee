function said = fmu(file, varargin)
% VIBRO.FMU  Write an FMU of a machine, for Simulink and other hosts, without a compiler
%
%   said = vibro.fmu('damper.toml', 'fmi', 2, 'kit', 'machine-kit.zip', 'out', 'archives');
%
%   The result is the text with the name of the archive. Without 'out' the folder is vibro-out.
%   `vibro fmu --help` lists the places where the prebuilt library, machine-kit.zip, is found.
  said = vibro.inner.written('fmu', file, varargin{:});
end
