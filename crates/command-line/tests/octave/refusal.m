function refusal(call)
% Prints the identifier and the message of the error that a call must have.
  try
    call();
  catch refused
    printf('%s\n%s\n', refused.identifier, refused.message);
    return
  end
  printf('no error\n');
end
