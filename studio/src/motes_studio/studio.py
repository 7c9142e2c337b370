"""The studio without its network: films, sessions on disk, and those that are open."""

from __future__ import annotations

import asyncio
import time
from pathlib import Path

from motes import ConfigError
from motes_studio.films import Films
from motes_studio.messages import Preset, Presets
from motes_studio.safety import Limits
from motes_studio.sessions import LiveSession
from motes_studio.store import Store

IDLE = 60.0
"""Seconds after which a session that nobody looks at, and in which nothing runs, is closed."""
ROUND = 5.0
"""Seconds between looks for such sessions."""


class Studio:
    """Films and sessions.

    Parameters
    ----------
    folder
        The films of a user; None for uploads alone.
    data
        Where sessions and uploads are kept.
    limits
        What is taken at most.
    """

    def __init__(self, folder: Path | None, data: Path, limits: Limits) -> None:
        self.limits = limits
        self.store = Store(data / "studio.sqlite")
        self.films = Films(folder, data / "uploads", limits)
        self._open: dict[str, LiveSession] = {}
        self._used: dict[str, float] = {}
        self._locks: dict[str, asyncio.Lock] = {}

    async def begin(self, film: str, *, uploaded: bool, anew: bool = False) -> LiveSession:
        """Open the session of a film that changed last; make one if there is none, or `anew`.

        One in which nothing was done, and at which nobody looks, is as good as a new one. A new one
        that cannot be opened is removed.
        """
        self.films.path(film, uploaded=uploaded)
        for name, touched in self.store.of_film(film, uploaded=uploaded):
            idle = name not in self._open or not self._open[name].busy
            if not anew or (idle and not touched):
                return await self.session(name)
        name = self.store.begin(film, uploaded=uploaded)
        try:
            return await self.session(name)
        except BaseException:
            self.store.remove(name)
            raise

    async def session(self, name: str) -> LiveSession:
        """Return a session, which is opened if it is not.

        Raises
        ------
        MotesError
            If there is none, its film cannot be read, or too many are open.
        """
        if name not in self._open:
            self.store.session(name)  # an unknown name leaves no trace
        self._used[name] = time.monotonic()
        async with self._locks.setdefault(name, asyncio.Lock()):
            if name not in self._open:
                film, uploaded, *_ = self.store.session(name)
                path = self.films.path(film, uploaded=uploaded)
                self._make_room()
                session = LiveSession(
                    name, path, self.store, self.limits, lambda: self._reopen(name)
                )
                self._open[name] = session
                try:
                    await session.open()
                except BaseException:
                    self._open.pop(name, None)  # it may have been removed meanwhile
                    session.close()
                    raise
            return self._open[name]

    def remove(self, name: str) -> None:
        """Remove a session, open or not."""
        self.store.session(name)
        if name in self._open:
            self._open.pop(name).close()
        self._used.pop(name, None)
        self._locks.pop(name, None)
        self.store.remove(name)

    def _make_room(self) -> None:
        """Close the session that has waited longest if as many are open as may be."""
        if len(self._open) < self.limits.sessions:
            return
        idle = [name for name, session in self._open.items() if not session.busy]
        if not idle:
            raise ConfigError(
                f"{self.limits.sessions} sessions are open, as many as may be; close one."
            )
        self._open.pop(min(idle, key=lambda name: self._used[name])).close()

    def _reopen(self, name: str) -> None:
        """Close a session that is to be opened anew; its pages come back by themselves."""

        def close() -> None:
            if session := self._open.pop(name, None):
                session.close()

        asyncio.get_running_loop().call_soon(close)  # once its answers have been taken

    async def tidy(self) -> None:
        """Close sessions that nobody needs, until cancelled."""
        while True:
            await asyncio.sleep(ROUND)
            now = time.monotonic()
            for name, session in [*self._open.items()]:
                if session.busy:
                    self._used[name] = now
                elif now - self._used[name] > IDLE:
                    self._open.pop(name).close()

    def close(self) -> None:
        """Close all sessions."""
        for session in self._open.values():
            session.close()
        self._open.clear()
        self.store.close()


def presets() -> Presets:
    """Return the trackers that can be chosen."""
    from motes import PRESETS, ParticleFilter
    from motes.sot import DESCRIPTIONS

    all_ = [Preset(*each) for each in DESCRIPTIONS.items()]
    return Presets(all_, [each for each in all_ if isinstance(PRESETS[each.name], ParticleFilter)])
