function words = quoted(words)
% An argument as the system's shell reads it: one word, with every character as it is.
  if ispc
    words = ['"', strrep(words, '"', '\"'), '"'];
  else
    words = ['''', strrep(words, '''', '''\'''''), ''''];
  end
end
