"""Random plans: the executor against a plain interpreter of the plan, and files written and read again."""

import json
import math
from dataclasses import replace

from hypothesis import given, settings
from hypothesis import strategies as st

from companion.core.decision import MissionState
from companion.mission import qgc_plan, waypoints
from companion.mission.executor import MissionExecutor
from companion.mission.plan import PlanItem, PlanKind, Plans, plan_id
from companion.mission.plan_file import PlanFile
from companion.mission.tasks import Complete, Sail, SetSpeed
from companion.mission.validation import check_item, check_plan

_MOST_VISITS = 400
_LARGE = settings(deadline=None, derandomize=True, max_examples=100)


@st.composite
def _item(draw: st.DrawFn, count: int) -> PlanItem:
    command = draw(st.sampled_from([16, 16, 16, 16, 17, 19, 20, 93, 115, 177, 177, 178, 206]))
    params = [0.0, 0.0, 0.0, math.nan]
    if command == 16:
        params[0] = draw(st.sampled_from([0.0, 0.0, 0.0, 5.0]))
        params[3] = draw(st.sampled_from([math.nan, math.nan, 0.0, 90.0]))
    elif command == 115:
        params = [
            draw(st.sampled_from([0.0, 90.0, 350.0])),
            0.0,
            draw(st.sampled_from([-1.0, 0.0, 1.0])),
            draw(st.sampled_from([0.0, 1.0])),
        ]
    elif command == 177:
        params = [float(draw(st.integers(0, count - 1))), draw(st.sampled_from([-1.0, 0.0, 1.0, 2.0, 3.0])), 0.0, 0.0]
    elif command == 178:
        params = [1.0, draw(st.sampled_from([-2.0, -1.0, 0.5, 1.5])), -1.0, 0.0]
    x = 634389000 + draw(st.integers(-5000, 5000))
    return PlanItem(0, command, 3 if command in (16, 17, 19) else 2, *params, x, 103990000, 50.0)


@st.composite
def _missions(draw: st.DrawFn) -> tuple[PlanItem, ...]:
    count = draw(st.integers(1, 9))
    return tuple(replace(draw(_item(count)), seq=seq) for seq in range(count))


_PLANS = _missions().filter(lambda items: check_plan(PlanKind.MISSION, items) is None)


def _interpret(items: tuple[PlanItem, ...]) -> list[tuple[int, float | None]]:
    """(item, speed there) as a reader of the plan would go through it with a finger, for as long as somebody has
    patience."""
    visits: list[tuple[int, float | None]] = []
    taken = [0] * len(items)
    speed: float | None = None
    at = 0
    while at < len(items) and len(visits) < _MOST_VISITS:
        item = items[at]
        if item.command == 177 and (item.param2 == -1 or taken[at] < item.param2):
            taken[at] += 1
            at = int(item.param1)
            continue
        if item.command == 178 and item.param2 != -1:
            speed = item.param2 if item.param2 > 0 else None
        if item.command in (16, 17, 19, 20, 93, 115):
            visits.append((at, speed))
        at += 1
    return visits


def _sail(executor: MissionExecutor, most: int) -> list[tuple[int, float | None]]:
    """Does each task in turn, and notes each item once."""
    visits: list[tuple[int, float | None]] = []
    speed: float | None = None
    for action in executor.take_actions():
        speed = action.speed_mps if isinstance(action, SetSpeed) else speed
    while len(visits) < most and executor.progress.state is MissionState.ACTIVE:
        task = executor.task
        assert task is not None and not isinstance(task, Complete)
        route = task.route if isinstance(task, Sail) else ()
        for point in route:
            visits.append((point.seq, point.speed_mps))
            assert point.speed_mps == speed
            assert executor.progress.seq == point.seq
            assert executor.task is task
            for action in executor.complete(point.seq):
                speed = action.speed_mps if isinstance(action, SetSpeed) else speed
        if not isinstance(task, Sail):
            if not visits or visits[-1][0] != task.seq or type(task).__name__ != "Stay":
                visits.append((task.seq, speed))
            for action in executor.complete(task.seq):
                speed = action.speed_mps if isinstance(action, SetSpeed) else speed
    return visits[:most]


def _begun(items: tuple[PlanItem, ...]) -> MissionExecutor:
    plans = Plans()
    plans.replace(PlanKind.MISSION, items)
    executor = MissionExecutor(plans)
    assert executor.begin() is None
    return executor


@_LARGE
@given(_PLANS)
def test_the_executor_visits_what_the_plan_says(items: tuple[PlanItem, ...]) -> None:
    expected = _interpret(items)
    if not expected:  # all tasks are jumped over
        plans = Plans()
        plans.replace(PlanKind.MISSION, items)
        assert MissionExecutor(plans).begin() is not None
        return
    executor = _begun(items)
    assert _sail(executor, _MOST_VISITS) == expected
    if len(expected) < _MOST_VISITS:
        assert executor.progress.state is MissionState.COMPLETE


@_LARGE
@given(_PLANS.filter(lambda items: len(_interpret(items)) > 1), st.integers(0, 60))
def test_interrupted_anywhere_it_goes_on_as_if_it_were_not(items: tuple[PlanItem, ...], steps: int) -> None:
    executor, twin = _begun(items), _begun(items)
    for _ in range(steps):
        task = executor.task
        assert task is not None
        if isinstance(task, Complete):
            break
        seq = task.route[0].seq if isinstance(task, Sail) else task.seq
        assert executor.complete(seq) == twin.complete(seq)
        twin.take_actions()
        executor.pause()
        if twin.progress.state is MissionState.COMPLETE:
            break
        assert executor.begin() is None
        kept = json.loads(json.dumps(executor.snapshot()))
        executor = _begun(items)
        executor.take_actions()
        assert executor.restore(kept) is None
        executor.take_actions()  # the camera is told again what it does
        assert executor.progress == twin.progress
        twin.pause()
        twin.begin()
        assert executor.task == twin.task


@_LARGE
@given(_PLANS, st.lists(st.tuples(st.integers(0, 5), st.integers(-1, 9)), max_size=40))
def test_no_order_of_calls_leads_astray(items: tuple[PlanItem, ...], calls: list[tuple[int, int]]) -> None:
    plans = Plans()
    plans.replace(PlanKind.MISSION, items)
    executor = MissionExecutor(plans)
    for kind, seq in calls:
        if kind == 0:
            executor.complete(seq)
        elif kind == 1:
            executor.begin()
        elif kind == 2:
            executor.pause()
        elif kind == 3:
            executor.set_current(seq, reset=seq % 2 == 0)
        elif kind == 4:
            executor.begin(seq)
        else:
            plans.replace(PlanKind.MISSION, items[: max(0, seq)])
        progress = executor.progress
        assert 0 <= progress.seq <= max(0, progress.count - 1)
        assert (executor.task is not None) == (progress.state in (MissionState.ACTIVE, MissionState.COMPLETE))
        if progress.state is MissionState.ACTIVE:
            task = executor.task
            assert task is not None and not isinstance(task, Complete)
            assert executor.task is task
            assert (
                task.route[0].seq if isinstance(task, Sail) and len(task.route) == 1 else progress.seq
            ) == progress.seq


_FLOAT = st.floats(width=32, allow_infinity=False, allow_nan=False) | st.just(math.nan)  # text knows one NaN only
_LAT = st.integers(-900_000_000, 900_000_000)
_LON = st.integers(-1_800_000_000, 1_800_000_000)


@st.composite
def _any_item(draw: st.DrawFn, count: int) -> PlanItem:
    """Of any command and float frame, with raw integers in a frame that is not global."""
    command = draw(st.sampled_from([16, 17, 19, 20, 93, 115, 177, 178, 179, 206, 2000]))
    frame = draw(st.sampled_from([0, 2, 3, 10]))
    raw = st.integers(-(2**31) + 1, 2**31 - 1)
    x, y = (draw(raw), draw(raw)) if frame == 2 else (draw(_LAT), draw(_LON))
    first = float(draw(st.integers(0, count - 1))) if command == 177 else draw(_FLOAT)
    return PlanItem(
        0, command, frame, first, *(draw(_FLOAT) for _ in range(3)), x, y, draw(_FLOAT), draw(st.integers(0, 1))
    )


@st.composite
def _any_mission(draw: st.DrawFn) -> tuple[PlanItem, ...]:
    count = draw(st.integers(1, 8))
    return tuple(replace(draw(_any_item(count)), seq=seq) for seq in range(count))


_HOMES = st.tuples(_LAT, _LON.filter(bool), st.integers(-100, 1000)).map(
    lambda home: (home[0] / 1e7, home[1] / 1e7, float(home[2]))
)


def _same(a: tuple[PlanItem, ...], b: tuple[PlanItem, ...]) -> bool:
    """To the last bit, NaN included."""
    return plan_id(a) == plan_id(b) and [(i.seq, i.autocontinue) for i in a] == [(i.seq, i.autocontinue) for i in b]


@_LARGE
@given(_any_mission(), _HOMES)
def test_a_waypoint_file_keeps_everything(items: tuple[PlanItem, ...], home: tuple[float, float, float]) -> None:
    back = waypoints.read("a.waypoints", waypoints.write("a.waypoints", PlanFile(items, home=home)))
    assert _same(back.mission, items)
    assert back.home == home


@st.composite
def _zones(draw: st.DrawFn) -> tuple[PlanItem, ...]:
    """In the order of the file: polygons, circles, return point."""
    result: list[PlanItem] = []

    def add(command: int, p1: float, frame: int, z: float) -> None:
        result.append(PlanItem(len(result), command, frame, p1, 0.0, 0.0, 0.0, draw(_LAT), draw(_LON), z))

    for count in draw(st.lists(st.integers(3, 6), max_size=3)):
        command = draw(st.sampled_from([5001, 5002]))
        for _ in range(count):
            add(command, float(count), 0, 0.0)
    for radius in draw(st.lists(st.floats(0.5, 1e5, width=32), max_size=3)):
        add(draw(st.sampled_from([5003, 5004])), radius, 0, 0.0)
    if draw(st.booleans()):
        add(5000, 0.0, 3, 12.0)
    return tuple(result)


@_LARGE
@given(_any_mission(), _HOMES, _zones(), st.lists(st.tuples(_LAT, _LON), max_size=4), st.none() | st.floats(0.1, 20.0))
def test_a_plan_file_keeps_everything(
    items: tuple[PlanItem, ...],
    home: tuple[float, float, float],
    fence: tuple[PlanItem, ...],
    places: list[tuple[int, int]],
    speed: float | None,
) -> None:
    rally = tuple(PlanItem(seq, 5100, 3, 0.0, 0.0, 0.0, 0.0, x, y, 5.0) for seq, (x, y) in enumerate(places))
    back = qgc_plan.read("a.plan", qgc_plan.write("a.plan", PlanFile(items, fence, rally, home, speed)))
    assert _same(back.mission, items)
    assert (back.fence, back.rally, back.home, back.cruise_speed_mps) == (fence, rally, home, speed)


@_LARGE
@given(st.text(max_size=200), st.sampled_from(["", "QGC WPL 110\n", "QGC WPL 110\n0\t1\t0\t16\t"]))
def test_any_text_is_read_or_refused(text: str, start: str) -> None:
    for module in (waypoints, qgc_plan):
        try:
            module.read("a", start + text)
        except module.PlanFileError as error:
            assert error.problems


@_LARGE
@given(
    st.sampled_from(list(PlanKind)),
    st.lists(
        st.builds(
            PlanItem,
            st.integers(0, 5),
            st.sampled_from([16, 17, 19, 20, 31, 93, 115, 177, 178, 179, 5000, 5001, 5002, 5003, 5004, 5100]),
            st.sampled_from([0, 1, 2, 3, 6]),
            *[st.floats() | st.sampled_from([3.0, 4.0, -1.0, 0.0])] * 4,
            st.integers(-(2**31), 2**31 - 1),
            st.integers(-(2**31), 2**31 - 1),
            st.floats(),
        ),
        max_size=6,
    ),
)
def test_any_list_is_taken_or_refused_with_an_item_and_a_text(kind: PlanKind, items: list[PlanItem]) -> None:
    numbered = [replace(item, seq=seq) for seq, item in enumerate(items)]
    for refusal in (check_plan(kind, items), check_plan(kind, numbered), *(check_item(kind, item) for item in items)):
        if refusal is not None:
            assert refusal.text
            assert refusal.seq is None or str(refusal).startswith(f"item {refusal.seq + 1}: ")
