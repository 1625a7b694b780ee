function column = numbers(cells)
% The numbers of a column's cells; the cells themselves, if one of them is neither a number nor empty.
  number = '^([+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|[+-]?inf|NaN)$';
  is_number = cellfun('isempty', cells) | ~cellfun('isempty', regexp(cells, number, 'once'));
  if all(is_number)
    column = reshape(str2double(cells), [], 1);
  else
    column = cells;
  end
end
