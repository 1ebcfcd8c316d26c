"""Tables of an estimate. Truth: the estimate that they are of."""

from mechid.exports.tables.estimate_tables import _parameters
from mechid.identification.result.parameter_estimate import ParameterEstimate


def test_the_table_of_parameters_tells_those_that_the_fit_added():
    own = {"symbol": "k", "unit": "1", "value": 1.0, "std_error": None, "std_error_white": None, "start": 1.0}
    own |= {"min": None, "max": None, "status": "free"}
    parameters = {name: ParameterEstimate(name=name, added=name == "b", **own) for name in ("a", "b")}
    columns = {column.name: list(column.values) for column in _parameters(parameters).columns}
    assert columns["parameter"] == ["a", "b"]
    assert columns["added"] == ["", "yes"]
