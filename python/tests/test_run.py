"""How a run behaves beside the interpreter."""

import multiprocessing
import signal
import threading

import pytest
import veloid
from conftest import QUICK

LONG = {"trials": 100, "particles": 1000, "iterations": 20, "diagnosis": False}


def test_progress_is_told_on_the_callers_thread(simulated):
    steps = []
    veloid.identify(
        simulated.ride, simulated.bike, progress=lambda s: steps.append((s, threading.current_thread())), **QUICK
    )
    assert {thread for _, thread in steps} == {threading.main_thread()}
    stages = list(dict.fromkeys(step.stage for step, _ in steps))
    assert stages == ["observe", "trials", "conclude"]
    counted = [step.done for step, _ in steps if step.total]
    assert sorted(counted) == list(range(1, 11)) and steps[-2][0].total == 10


def test_what_the_callback_raises_ends_the_work(simulated):
    class Enough(Exception):
        pass

    def stop(step):
        if step.stage == "trials" and step.done:
            raise Enough

    with pytest.raises(Enough):
        veloid.identify(simulated.ride, simulated.bike, progress=stop, **LONG)


def test_ctrl_c_ends_the_work(simulated):
    """It comes once the work has begun, while the engine has the thread; without it all 2 000 000 simulations would be made."""
    begun = threading.Event()
    main = threading.main_thread().ident

    def interrupt():
        begun.wait()
        signal.pthread_kill(main, signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    thread.start()
    with pytest.raises(KeyboardInterrupt):
        veloid.identify(simulated.ride, simulated.bike, progress=lambda _: begun.set(), **LONG)
    thread.join()


def test_other_threads_run_meanwhile(simulated):
    """Another thread of Python counts while the engine works; as soon as it has got on, the work may end."""

    class GotOn(Exception):
        pass

    counted = 0
    ended = threading.Event()

    def count():
        nonlocal counted
        while not ended.wait(1e-3):
            counted += 1

    def look(step):
        if step.stage == "trials" and counted >= 10:
            raise GotOn

    thread = threading.Thread(target=count)
    thread.start()
    try:
        with pytest.raises(GotOn):
            veloid.identify(simulated.ride, simulated.bike, progress=look, **LONG)
    finally:
        ended.set()
        thread.join()


def test_threads_may_identify_at_once(simulated):
    texts = []
    run = lambda: texts.append(veloid.identify(simulated.ride, simulated.bike, **QUICK).text)  # noqa: E731
    threads = [threading.Thread(target=run) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(texts) == 3 and len(set(texts)) == 1


def of_child(ride, bike):
    return veloid.identify(ride, bike, **QUICK).text


@pytest.mark.filterwarnings("ignore:.*multi-threaded.*:DeprecationWarning")
def test_a_process_that_has_identified_may_fork(simulated):
    own = of_child(simulated.ride, simulated.bike)
    with multiprocessing.get_context("fork").Pool(1) as pool:
        assert pool.apply_async(of_child, (simulated.ride, simulated.bike)).get(timeout=120) == own
