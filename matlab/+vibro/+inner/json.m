function value = json(text)
% Value of a JSON text. Numbers have every digit of the text: Octave's `jsondecode` rounds some of
% them to a neighbouring double, so that it gets them as texts with a mark.
  mark = '\u0001';
  [strings, others] = regexp(text, '"(\\.|[^"\\])*"', 'match', 'split');
  number = '(-?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)';
  others = regexprep(others, number, ['"', strrep(mark, '\', '\\'), '$1"']);
  parts = [others; [strings, {''}]];
  value = numbers_in(jsondecode([parts{:}]));
end

% The same value with marked texts as numbers, and lists of numbers as columns and matrices.
function value = numbers_in(value)
  if ischar(value) && ~isempty(value) && value(1) == char(1)
    value = str2double(value(2:end));
  elseif isstruct(value)
    names = fieldnames(value);
    for k = 1:numel(value)
      for i = 1:numel(names)
        value(k).(names{i}) = numbers_in(value(k).(names{i}));
      end
    end
  elseif iscell(value) && ~isempty(value)
    value = cellfun(@numbers_in, value, 'UniformOutput', false);
    lengths = cellfun(@numel, value);
    if all(cellfun(@isnumeric, value)) && all(lengths == lengths(1)) && lengths(1) > 0
      rows = cellfun(@(row) reshape(row, 1, []), value, 'UniformOutput', false);
      value = vertcat(rows{:});
    end
  end
end
