"""Sentences: framing, checksums, faults."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grex_agent.modem.nmea import LONGEST, Sentence, SentenceReader, checksum, encode

#: As real modems and their documentation print them.
PRINTED = {
    b"$CAMPA,1,2*5D": Sentence("CAMPA", ("1", "2")),
    b"$CAMPR,2,1,0.0101*7C": Sentence("CAMPR", ("2", "1", "0.0101")),
    b"$CAMUA,1,2,1fab*20": Sentence("CAMUA", ("1", "2", "1fab")),
    b"$CAREV,000052,AUV,0.93.0.09*07": Sentence("CAREV", ("000052", "AUV", "0.93.0.09")),
    b"$CAREV,181807,AUV,2.0.27087*12": Sentence("CAREV", ("181807", "AUV", "2.0.27087")),
    b"$CAREV,181807,COPROC,0.20.0.56*45": Sentence("CAREV", ("181807", "COPROC", "0.20.0.56")),
    b"$CACFG,SRC,1*33": Sentence("CACFG", ("SRC", "1")),
    b"$CCTXD,2,1,1,*7A": Sentence("CCTXD", ("2", "1", "1", "")),
}


@pytest.mark.parametrize("line", PRINTED, ids=bytes.decode)
def test_sentences_of_real_modems(line):
    """What real modems print is read, and written the same way."""
    reader = SentenceReader()
    assert reader.feed(line + b"\r\n") == [PRINTED[line]]
    assert reader.faults == {}
    sentence = PRINTED[line]
    assert encode(sentence.kind, *sentence.fields) == line + b"\r\n"


def test_checksum_by_hand():
    """The checksum is the exclusive or of everything between dollar and asterisk."""
    assert checksum(b"AB") == 0x41 ^ 0x42
    assert encode("CCMPC", 1, 2) == b"$CCMPC,1,2*5D\r\n"


@given(cuts=st.lists(st.integers(0, 400), max_size=30))
def test_pieces_do_not_matter(cuts):
    """The same bytes give the same sentences, in whatever pieces they come."""
    line = b"".join(encode("CARXD", 1, 2, 0, place, "AB" * 20) for place in range(1, 6))
    edges = [0, *sorted(min(cut, len(line)) for cut in cuts), len(line)]
    reader = SentenceReader()
    found = [s for start, end in pairwise(edges) for s in reader.feed(line[start:end])]
    assert [sentence.fields[3] for sentence in found] == ["1", "2", "3", "4", "5"]
    assert reader.faults == {}


@pytest.mark.parametrize("end", [b"\r\n", b"\r", b"\n", b"\n\r\n\r"])
def test_any_end_of_line(end):
    """Carriage return, line feed or both end a sentence."""
    assert len(SentenceReader().feed(b"$CACFG,SRC,1*33" + end)) == 1


@pytest.mark.parametrize(
    ("line", "fault"),
    [
        (b"$CACFG,SRC,2*33\r\n", "bad_checksum"),
        (b"$CACFG,SRC,1\r\n", "no_checksum"),
        (b"$cacfg,SRC,1*33\r\n", "malformed"),
        (b"$CACFG,SRC,1*3\r\n", "malformed"),
        (b"$CACFG,S*RC,1*33\r\n", "malformed"),
        (b"$CACFG,SR\xc3,1*33\r\n", "non_ascii"),
        (b"$CACFG,SR\0,1*33\r\n", "non_ascii"),
        (b"$" + b"A" * LONGEST + b"*00\r\n", "overlong"),
        (b"$CACFG,S", "cut_off"),
    ],
)
def test_faults_are_counted(line, fault):
    """A sentence that is wrong is counted by what is wrong, and the next one is read."""
    reader = SentenceReader()
    assert reader.feed(line + b"$CACFG,SRC,1*33\r\n") == [PRINTED[b"$CACFG,SRC,1*33"]]
    assert reader.faults == {fault: 1}


def test_bytes_outside_of_sentences_are_counted():
    """A console's chatter between sentences is counted and changes nothing."""
    reader = SentenceReader()
    assert len(reader.feed(b"boot> \r\n$CACFG,SRC,1*33\r\nok")) == 1
    assert reader.faults == {"stray_bytes": len("boot> ") + len("ok")}


def test_a_cut_line_begins_anew():
    """What had begun before the port was lost is not mixed with what comes after."""
    reader = SentenceReader()
    reader.feed(b"$CACFG,SR")
    reader.reset()
    assert reader.feed(b"C,1*33\r\n$CACFG,SRC,1*33\r\n") == [PRINTED[b"$CACFG,SRC,1*33"]]
    assert reader.faults == {"cut_off": 1, "stray_bytes": 6}


@given(pieces=st.lists(st.one_of(st.binary(max_size=200), st.sampled_from([*PRINTED, b"\r\n", b"$", b"*"]))))
def test_never_raises_and_never_grows(pieces):
    """Any bytes whatever are taken, and nothing is kept beyond the longest sentence."""
    reader = SentenceReader()
    for piece in pieces:
        for sentence in reader.feed(piece):
            assert len(sentence.kind) == 5
        assert len(reader._begun) <= LONGEST


def test_an_endless_line_is_one_fault():
    """A line that never ends costs no memory and counts once."""
    reader = SentenceReader()
    for _ in range(100):
        reader.feed(b"x" * 1000 if reader.faults else b"$CARXD," + b"x" * LONGEST)
    assert reader.faults == {"overlong": 1}
    assert len(reader.feed(b"\n$CACFG,SRC,1*33\n")) == 1
