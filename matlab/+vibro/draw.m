function said = draw(file, varargin)
% VIBRO.DRAW  Draw a sketch of a machine as SVG and PNG
%
%   said = vibro.draw('damper.toml', 'out', 'sketches');
%
%   The result is the text with the names of the files. Without 'out' the folder is vibro-out.
  said = vibro.inner.written('draw', file, varargin{:});
end
