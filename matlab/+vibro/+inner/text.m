function words = text(value, what)
% A text or a number as a row of characters. A number keeps every digit.
  if exist('string', 'class') == 8 && isa(value, 'string') && isscalar(value)
    value = char(value);
  end
  if ischar(value) && (isrow(value) || isempty(value))
    words = value;
  elseif isnumeric(value) && isreal(value) && isscalar(value)
    words = sprintf('%.17g', value);
  else
    error('vibro:refused', '%s is a %s of size %s; expected a text or a number', ...
          what, class(value), mat2str(size(value)));
  end
end
