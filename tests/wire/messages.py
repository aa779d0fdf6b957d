"""Random messages of the protocol, drawn from its own specification, and what they decode to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from hypothesis import strategies as st

from motorid.wire import codec
from motorid.wire.enums import Channel, Status
from motorid.wire.spec import Field, load

SPEC = load()
REQUESTS = st.integers(1, 0xFFFF)
INTEGERS = {
    "u8": st.integers(0, 0xFF),
    "u16": st.integers(0, 0xFFFF),
    "u32": st.integers(0, 0xFFFFFFFF),
    "i16": st.integers(-0x8000, 0x7FFF),
    "i32": st.integers(-0x80000000, 0x7FFFFFFF),
}
TYPES: dict[str, st.SearchStrategy[Any]] = {
    **INTEGERS,
    "f32": st.floats(width=32, allow_nan=False),
    "text16": st.text(st.characters(min_codepoint=1, max_codepoint=0x7F), max_size=16),
}


@dataclass(frozen=True)
class Sent:
    """A payload and the message that it must decode to."""

    payload: bytes
    message: codec.Command | codec.Reply | codec.Event | codec.SampleBlock

    @property
    def ends(self) -> set[int]:
        """Lengths at which the payload of an older minor ends."""
        match self.message:
            case codec.Command(name=name):
                fields = SPEC.commands[name].fields
            case codec.Reply(name=name, fields=found) if found:
                fields = SPEC.commands[name].reply
            case _:
                return set()
        new = [field.size for field in fields if field.since]
        return {len(self.payload) - sum(new[n:]) for n in range(len(new))}


def values(fields: tuple[Field, ...]) -> st.SearchStrategy[dict[str, Any]]:
    """Any value in every field."""
    return st.fixed_dictionaries({field.name: TYPES[field.type] for field in fields})


@st.composite
def commands(draw: st.DrawFn) -> Sent:
    message = draw(st.sampled_from(list(SPEC.commands.values())))
    request, fields = draw(REQUESTS), draw(values(message.fields))
    payload = codec.encode_command(message.name, request, **fields)
    return Sent(payload, codec.Command(message.name, request, fields))


@st.composite
def replies(draw: st.DrawFn) -> Sent:
    message = draw(st.sampled_from(list(SPEC.commands.values())))
    request, fields = draw(REQUESTS), draw(values(message.reply))
    status = draw(st.sampled_from(Status))
    payload = codec.encode_reply(message.name, request, status, **fields)
    return Sent(payload, codec.Reply(message.name, request, status, {} if status else fields))


@st.composite
def events(draw: st.DrawFn) -> Sent:
    names = [name for name in SPEC.events if name != codec.SAMPLE_BLOCK]
    message = SPEC.events[draw(st.sampled_from(names))]
    fields = draw(values(message.fields))
    return Sent(codec.encode_event(message.name, **fields), codec.Event(message.name, fields))


@st.composite
def sample_blocks(draw: st.DrawFn) -> Sent:
    channels = tuple(sorted(draw(st.sets(st.sampled_from(Channel), min_size=1))))
    count = draw(st.integers(1, 28))
    seed = draw(st.integers(0, 0xFFFF))
    wide = np.random.default_rng(seed).integers(-0x8000, 0x8000, (count, len(channels)))
    samples = wide.astype(np.int16)
    head = draw(
        st.fixed_dictionaries(
            {
                "sequence": INTEGERS["u16"],
                "first_tick": INTEGERS["u32"],
                "dropped": INTEGERS["u16"],
                "position": INTEGERS["u32"],
            }
        )
    )
    payload = codec.encode_event(
        codec.SAMPLE_BLOCK, channels=codec.channel_mask(channels), samples=samples, **head
    )
    return Sent(payload, codec.SampleBlock(channels=channels, samples=samples, **head))


ANY = st.one_of(commands(), replies(), events(), sample_blocks())
