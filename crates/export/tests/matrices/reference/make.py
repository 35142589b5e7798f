"""Writes the files of this folder by NumPy and SciPy, and reads back what this crate wrote.

    python make.py            # makes the files
    python make.py FILE...    # checks files that the crate wrote, as the test `written` leaves them

The matrices are small and exact in every type; what they are stands in ../main.rs as well.
"""

import struct
import sys
from pathlib import Path

import numpy as np
import scipy.io
import scipy.sparse

FOLDER = Path(__file__).parent
W = np.array([[0.0, 1.5, -2.25], [3.0, 1e-300, 65504.0]])
V = np.array([1.0, 2.0, 3.0])


def make():
    everything = {
        "c_order": W,
        "fortran_order": np.asfortranarray(W),
        "single": W.astype("f4"),
        "half": np.array([[0.5, -1.0]], "f2"),
        "big_endian": W.astype(">f8"),
        "int8": np.array([[-128, 127]], "i1"),
        "uint16": np.array([[0, 65535]], ">u2"),
        "int64": np.array([[-(2**53), 2**53]]),
        "logical": np.array([[True, False]]),
        "vector": V,
        "number": np.float64(7.5),
        "empty": np.zeros((0, 3)),
        "cube": np.zeros((2, 2, 2)),
        "text": np.array(["a", "bc"]),
        "complex": np.array([[1j]]),
        "structured": np.zeros(2, [("shape", "<f8"), ("b", "<i4")]),
    }
    np.savez(FOLDER / "stored.npz", **everything)
    np.savez_compressed(FOLDER / "packed.npz", **everything)
    np.save(FOLDER / "single.npy", W)
    variables = {
        "w": W,
        "single": W.astype("f4"),
        "int8": np.array([[-128, 127]], "i1"),
        "uint16": np.array([[0, 65535]], "u2"),
        "int64": np.array([[-(2**53), 2**53]]),
        "logical": np.array([[True, False]]),
        "vector": V,
        "number": 7.5,
        "empty": np.zeros((0, 3)),
        "cube": np.zeros((2, 2, 2)),
        "text": "a text",
        "complex": np.array([[1j]]),
        "sparse": scipy.sparse.csc_matrix(W),
        "cells": np.array([W, "x"], object),
        "structure": {"a": 1.0},
        "a_name_that_is_as_long_as_matlab_takes_one_x_x_x_x_x_x_x": W,
    }
    for name, packed in [("stored.mat", False), ("packed.mat", True)]:
        scipy.io.savemat(
            FOLDER / name, variables, do_compression=packed, long_field_names=True
        )
        forget_time(FOLDER / name)
    scipy.io.savemat(FOLDER / "level_4.mat", {"w": W}, format="4")
    big_endian(FOLDER / "big_endian.mat")


def forget_time(path):
    """The text of the header has the time of day."""
    content = bytearray(path.read_bytes())
    content[:116] = b"MATLAB 5.0 MAT-file".ljust(116)
    path.write_bytes(content)


def big_endian(path):
    """By hand: SciPy writes in the machine's order only. W as doubles and V as bytes, as MATLAB packs
    whole numbers."""

    def element(kind, data):
        padding = bytes(-len(data) % 8)
        return struct.pack(">II", kind, len(data)) + data + padding

    def small(kind, data):
        return struct.pack(">HH", len(data), kind) + data.ljust(4, b"\0")

    def variable(name, rows, columns, numbers):
        flags = element(6, struct.pack(">II", 6, 0))
        sizes = element(5, struct.pack(">ii", rows, columns))
        return element(14, flags + sizes + name + numbers)

    header = b"MATLAB 5.0 MAT-file".ljust(116) + bytes(8) + b"\x01\x00MI"
    w = variable(small(1, b"w"), 2, 3, element(9, W.T.astype(">f8").tobytes()))
    v = variable(element(1, b"vector"), 3, 1, small(2, bytes([1, 2, 3])))
    path.write_bytes(header + w + v)
    read = scipy.io.loadmat(path)
    assert np.array_equal(read["w"], W) and np.array_equal(read["vector"][:, 0], V)


def check(path):
    read = np.load(path) if path.endswith(".npz") else scipy.io.loadmat(path)
    assert np.array_equal(read["w"], W), read["w"]
    assert np.array_equal(read["vector"], V[:, None]), read["vector"]
    assert read["number"].shape == (1, 1) and read["number"][0, 0] == 7.5
    assert read["empty"].shape == (0, 3)
    assert read["nan"].shape == (1, 1) and np.isnan(read["nan"][0, 0])
    print(path, "is as it should be")


if __name__ == "__main__":
    for path in sys.argv[1:]:
        check(path)
    if len(sys.argv) == 1:
        make()
