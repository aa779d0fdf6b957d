"""Builds ``motorid.motor._batch`` from batch.c, at installation."""

import sys
from pathlib import Path

from cffi import FFI

HERE = Path(__file__).parent

DECLARATIONS = """
typedef struct {
    int samples, channels;
    const double *input;
    const unsigned char *open;
    const double *measured;
    const int *pick;
    const double *lag;
    double *squares;
    double *outputs;
} batch_record;
void batch_lti(const batch_record *r, int n, int states, const double *discrete);
void batch_friction(const batch_record *r, int n, const double *motor);
void batch_quadratic(const batch_record *r, int n, const double *motor, double dt, int substeps);
void batch_expm(int n, int m, const double *matrices, double *out);
"""

FLAGS = (
    ["/O2", "/fp:precise"]
    if sys.platform == "win32"
    else ["-O3", "-std=gnu11", "-ffp-contract=off", "-fno-trapping-math", "-fno-math-errno"]
)

ffi = FFI()
ffi.cdef(DECLARATIONS)
ffi.set_source(
    "motorid.motor._batch",
    (HERE / "batch.c").read_text(encoding="utf-8"),
    extra_compile_args=FLAGS,
)

if __name__ == "__main__":
    ffi.compile(verbose=True)
