function forget(path)
% Deletes a temporary file or folder, if it exists.
  if exist(path, 'dir') == 7
    if exist('OCTAVE_VERSION', 'builtin')
      confirm_recursive_rmdir(false, 'local');
    end
    rmdir(path, 's');
  elseif exist(path, 'file') == 2
    delete(path);
  end
end
