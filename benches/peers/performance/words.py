"""The words between the tables of docs/performance.md."""

HEAD = """\
# Performance

`make performance` makes this page on the machine at hand: {machine}, {cores} processors, raylet {raylet}. Rates are
in millions of rays at surfaces each second; the image plane counts as a surface, the place where rays start does not.
All numbers are of double precision. One core does {peak:.3g}e9 sums and products each second in NumPy's product of
matrices, and reads and writes {bandwidth:.3g}e9 bytes each second when it copies an array.

## Targets

What raylet aims at on two cores, and what was measured here. The tables below have these figures with their errors.

| what | target | measured | reached |
| --- | --- | --- | --- |
"""

RAY_HEAD = """
The design of figure 6 and the full draws of the source paper's systems are not part of this command; they are in
[Studies of the source paper](paper.md).

## Rays from Python, beside other ray tracers

Rays fill a part of the pupil at random and all arrive. The time of raylet has all that `System.trace(…, parts=-1)`
does, arrays included; that of Optiland {optiland} (NumPy {numpy}, PyTorch {torch}) its trace of rays that are there.
Memory is what a run takes beside its inputs. "Off" is the largest difference of a landing from that of raylet, in mm.
The row of NumPy is the formulas of a sphere and a plane in arrays, without edges and lost rays
(`benches/peers/performance/ray_rates.py`).

| lens | program | threads | rays | time | rate | memory | off in mm |
| --- | --- | --- | --- | --- | --- | --- | --- |
"""

GRADIENT_HEAD = """
## Rays with gradients by all curvatures, beside Optiland and DeepLens

The loss is the mean square of the distances of {rays:.0e} landings from the axis: `System.trace`, and `Rays.adjoint` of
what it returns, on two threads. Its rays go there and back, some at a time, so that its memory does not grow with
surfaces; Optiland {optiland} and DeepLens {deeplens-core} keep each ray at each surface for PyTorch. Rates are in
millions of rays at surfaces each second. "Off" is the relative difference of a gradient from that of raylet.

| lens | curvatures | raylet | memory | Optiland | memory | off | ratio | DeepLens | memory | off | ratio |
| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |
"""

LOOP_HEAD = """
## The loops of the library, on one core

`cargo bench -p raylet`, benchmarks `rays` and `speed`, medians. Blocks hold 128 rays in columns, eight in each vector
of the processor. They have the same bits with any vector instructions and beside any other rays. Their landings are
those of single rays to 1e-11 mm, their Jacobians and beamlets to 1e-10 and 1e-8
(`crates/raylet/src/engine/ray_block/hop_rays_test.rs`). Instructions and operations are counted step by step
(`crates/raylet/benches/instructions`); for each item of the rate they are sums and products, and quotients and roots.
The share is that of the core's sums and products each second, quotients and roots counted as one.

| loop | rate | instructions | sums, products | quotients, roots | share of the core |
| --- | --- | --- | --- | --- | --- |
"""

BOUNDS = """
No loop uses fused multiply-adds: with them results would have other bits on other machines. What bounds the loops:

- **Rays in blocks.** A surface has quotients and roots that wait for each other, and a processor begins one vector of
  them only every few cycles. The rest are sums and products with little to do side by side.
- **Rays from Python.** Where surfaces are few, the arrays of results take about as long: a fifth of the time of 1e6
  rays through the singlet, on one thread, is new pages of memory (by `perf`, on an EPYC with AVX-512). NumPy asks for
  large pages.
- **Gradients of rays.** `System.trace` follows each ray once, and `Rays.adjoint` twice more: there and back. A part on
  the way back has three quotients and two roots, most of which wait for each other.
- **Jacobians and beamlets.** The same, with four tangents or a complex curvature beside each ray: more sums and
  products for each quotient. More numbers are alive than a processor has registers, so many instructions load and
  store.
- **Single rays.** One ray fills one of the lanes of a vector. They serve where a ray must be searched, and in tests.
- **Sum of beamlets.** All values of a footprint follow from those of one column by products: two complex ones a value.
  Each value is added to the raster, a few rows of which stay in the cache.
- **Fourier sums.** Points in random order are sorted first. Then each adds to, or reads from, a small square of a fine
  grid; with 1024² modes the grid is larger than the cache.
- **Draws of the paper's method.** {draws:.3g} million draws each second. The Fourier sum takes a third of the time:
  waves are sorted, and each is added to 7 × 7 complex numbers of a fine grid. Cutting the patch takes a fifth, half of
  which is transforms of 200 values; drawing a seventh, tracing a tenth. Memory is used again from patch to patch.
"""

SUM_HEAD = """
## Fourier sums over scattered points, beside FINUFFT

`cargo run --release -p raylet --example nufft_speed` and FINUFFT {finufft}, 1e7 random points in double precision,
the best of three runs: type 1 from points to modes, type 2 from modes to points. Rates are in millions of points each
second, plans of FINUFFT included. Errors are those of twelve modes or points, against direct sums. Memory is in MB,
beside that of the points and their values.

| type | modes | tolerance | threads | raylet | error | memory | FINUFFT | error | memory | ratio |
| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |
"""

WHOLE_HEAD = """
## Whole runs

Planning included; the least of three runs, of the modulator one. Memory is what a run takes beside its inputs, the
error what raylet expects; [Accuracy](accuracy.md) and [Systems at their real size](real_size.md) compare such systems
with references.

| system | processor time | by the clock | memory | beamlets | expected error |
| --- | --- | --- | --- | --- | --- |
"""

OTHER_HEAD = """
## Gradients, designs and the start

`cargo bench -p raylet --bench speed`, medians on one thread. The hologram has 200² pixels before a catalogue lens and
256² pixels on the sensor; the numbers are a curvature, a conic constant, an index and the place of the sensor.
Gradients agree with differences to the figures in [Accuracy](accuracy.md).

| what | figure |
| --- | --- |
"""

GROWTH_HEAD = """
## Cost against work

Random pixels of 2 µm before a plano-convex lens of f = 50 mm, and a sensor of 128 µm in its focus: 128² pixels of it
behind more and more pixels of the element, and more and more of it behind 512² pixels. Two threads, one run each.

![Processor time and memory against the number of pixels](performance.png)

| more and more | pixels | beamlets | processor time | memory | expected error |
| --- | --- | --- | --- | --- | --- |
"""

TAIL = """
Changes of the loops are noticed without a clock: a test counts their instructions, with each kind of vector
instructions of the machine, and compares the counts with those that are stored (`crates/raylet/benches/instructions`,
`make instruction-counts`).

Times, memory and errors of whole systems are in [Systems at their real size](real_size.md); how they grow with the
aperture is a plot in [Cost and error against the aperture](aperture_scaling.md).
"""
