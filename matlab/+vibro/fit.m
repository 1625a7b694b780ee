function found = fit(file, varargin)
% VIBRO.FIT  Fit parameters of a machine to a record
%
%   found = vibro.fit('drive.toml', 'data', 'record.csv', 'free', 'spring.mount.stiffness,friction.guide.force');
%
%   The struct `found.fit` has the values, their errors and the verdict, the table `found.residuals`
%   record, motion and difference. With 'out' the folder has the fitted machine, fitted.toml.
%
%   Further arguments are options of `vibro fit`, each a name without dashes and a value: a text, a
%   number, true for an option without a value, or a cell for an option that is repeated. The results
%   are in a temporary folder unless 'out' names one. `vibro fit --help` lists all options.
  found = vibro.inner.study('fit', file, varargin{:});
end
