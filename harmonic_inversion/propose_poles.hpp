// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "harmonic_inversion/damped_pole.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"

#include <optional>
#include <string>
#include <vector>

namespace twang {

/// A set of poles that may describe a signal together, and who proposes it.
struct PoleProposal {
  std::string finder;  ///< "filter diagonalization", "matrix pencil" ...
  std::vector<PoleCandidate> candidates;
};

/// The samples on an even grid of `step_s`: stamps off the grid by less than a third of a step are
/// taken as on it, single gaps are bridged by straight lines; nothing if the stamps fit no grid or
/// more than 40 % of it is missing.
[[nodiscard]] std::optional<EvenSeries> on_even_grid(const SampleSeries& series, double step_s);

/// Candidate sets from filter diagonalization of the whole record and of the part in which the
/// signal lives, in the bands where the spectrum stands out of its median.
///
/// @param series   with its baseline removed
/// @param step_s   the usual distance of two samples [s]
[[nodiscard]] std::vector<PoleProposal> propose_by_filter_diagonalization(
    const SampleSeries& series, double step_s, const Band& band_hz);

/// Candidate sets from matrix pencils of several orders, of the part in which the signal lives
/// (thinned to a few hundred samples) and of its beginning.
[[nodiscard]] std::vector<PoleProposal> propose_by_matrix_pencil(const SampleSeries& series,
                                                                 double step_s,
                                                                 const Band& band_hz);

/// The places (f, d) at which one more damped sinusoid would explain most of a residual, by the
/// periodogram of the residual under exponential windows; uneven stamps are taken as they are.
///
///     gain(f, d) = sum_c |sum_n w_n r_n e^(-d t_n) e^(-i 2 pi f t_n)|² / (1/2 sum_n w_n e^(-2 d
///     t_n)),   w_n = 1 / sigma_n²
///
/// @param residuals  one a channel, in units of its noise; sigma_n = 1 where none are stated
/// @param excluded   places that were tried in vain
/// @return           at most `count`, largest gain first, amplitude = gain
[[nodiscard]] std::vector<PoleCandidate> search_residual(std::vector<SampleSeries> residuals,
                                                         double step_s,
                                                         const Band& band_hz,
                                                         const std::vector<DampedPole>& excluded,
                                                         int count);

}  // namespace twang
