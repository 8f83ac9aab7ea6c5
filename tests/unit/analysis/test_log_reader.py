"""Log folders read back."""

from __future__ import annotations

import json
import math
import tracemalloc
from pathlib import Path

import pytest

from companion.analysis.log_reader import LogError, open_log, parameters_of, read_table
from companion.config import vessel as config_module
from companion.config.vessel import VesselConfig
from companion.params.store import Parameters
from companion.params.table import table_of

REVOLT = config_module.load(config_module.find("revolt"))


def manifest(folder: Path, config: VesselConfig = REVOLT, **changes: object) -> Path:
    parameters = Parameters(table=table_of(config))
    values = {spec.name: parameters[spec.name] for spec in parameters.specs}
    entries = {"configuration": config_module.as_dict(config), "parameters": values, **changes}
    (folder / "manifest.json").write_text(json.dumps(entries, default=str), encoding="utf-8")
    return folder


@pytest.mark.parametrize("vessel", config_module.bundled())
def test_a_configuration_comes_back_whole(tmp_path: Path, vessel: str) -> None:
    config = config_module.load(config_module.find(vessel))
    log = open_log(manifest(tmp_path, config))
    assert log.config == config
    assert parameters_of(log, warnings := []).changed() == {} and warnings == []


def test_parameters_are_those_of_the_run(tmp_path: Path) -> None:
    warnings: list[str] = []
    log = open_log(manifest(tmp_path, parameters={"DP_DAMPING": 0.75, "OF_OLD": 1.0, "FS_POS_T": 1e6}))
    assert parameters_of(log, warnings).changed() == {"DP_DAMPING": 0.75}
    assert len(warnings) == 2 and "OF_OLD" in warnings[0]


def test_what_a_later_version_added_is_left_out_and_what_is_missing_is_said(tmp_path: Path) -> None:
    configuration = config_module.as_dict(config_module.load(config_module.find("revolt")))
    assert open_log(manifest(tmp_path, configuration={**configuration, "wings": 2})).config.name == "revolt"
    del configuration["hull"]
    with pytest.raises(LogError, match="hull"):
        open_log(manifest(tmp_path, configuration=configuration))


@pytest.mark.parametrize(
    "text", ["", "{", "[]", "{}", '{"configuration": {}, "parameters": {}}', '{"configuration": 3, "parameters": {}}']
)
def test_no_manifest_is_said(tmp_path: Path, text: str) -> None:
    with pytest.raises(LogError):
        open_log(tmp_path / "not there")
    (tmp_path / "manifest.json").write_text(text, encoding="utf-8")
    with pytest.raises(LogError):
        open_log(tmp_path)


def test_a_table_cut_off_in_its_last_line(tmp_path: Path) -> None:
    warnings: list[str] = []
    path = tmp_path / "t.csv"
    path.write_text('t_s,name,x\n0.0,"a",1.5\n0.1,"b",\n0.2,"c",x\n0.3,"d"\n0.4,"e",2', encoding="utf-8")
    table = read_table(path, ("t_s", "x"), warnings)
    assert list(table["t_s"]) == [0.0, 0.1] and table["x"][0] == 1.5 and math.isnan(table["x"][1])
    assert len(warnings) == 3
    with pytest.raises(LogError, match="no column y"):
        read_table(path, ("y",), [])


def test_a_long_log_takes_little_more_memory_than_its_numbers(tmp_path: Path) -> None:
    """So that the report of a day can be made on the boat."""
    path, count = tmp_path / "t.csv", 20_000
    names = [f"x{n}" for n in range(20)]
    rows = (",".join([f"{k / 10}", *(f"{k + n / 7:.5f}" for n in range(20))]) for k in range(count))
    path.write_text("\n".join([",".join(["t_s", *names]), *rows]) + "\n", encoding="utf-8")
    tracemalloc.start()
    table = read_table(path, ("t_s", *names), [], ("later",))
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert len(table["t_s"]) == len(table["later"]) == count
    assert most < 1.5 * 8 * count * 22
