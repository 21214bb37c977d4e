// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "harmonic_inversion/damped_pole.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"

#include <vector>

namespace twang {

struct FilterDiagonalizationOptions {
  int max_basis = 40;  ///< basis functions of one window; wider bands are cut into windows
  double rank_tolerance = 1e-11;  ///< singular values of U(0) below this part of the largest: null
  void check() const;
};

/// Poles of an evenly sampled signal inside a band, by filter diagonalization.
///
///     c_n = sum_k A_k u_k^n,   z_j = exp(-i 2 pi phi_j dt),   a = z_j,  b = z_k
///     U(p)_jk = sum_{n,m = 0..M} c_{n+m+p} a^n b^m
///             = [a F_p(a) - b F_p(b) + a^(M+1) b^-M G_p(b) - b^(M+1) a^-M G_p(a)] / (a - b)
///     F_p(z) = sum_{l = 0..M} c_{l+p} z^l,   G_p(z) = sum_{l = M+1..2M} c_{l+p} z^l
///     U(1) B = u U(0) B                                          [Mandelshtam & Taylor 1997]
///
/// A candidate's error is `‖(U(2) - u² U(0)) B‖ / ‖U(0) B‖`, its amplitude `2 |B^T c|²` with
/// `B^T U(0) B = 1`.
///
/// @return  candidates in the band, strongest first; growing ones too, errors as found
/// @throws InputError if the band is empty or reaches beyond Nyquist
/// The basis frequencies are those of a Fourier transform, whose three runs give F_p, G_p and the
/// diagonals of U(p) of all windows.
/// Cost: that of the transforms, and cubic in the basis functions of each window.
[[nodiscard]] std::vector<PoleCandidate> filter_diagonalize(
    const EvenSeries& signal,
    const Band& band_hz,
    const FilterDiagonalizationOptions& options = {});

/// The same for several bands at the price of one set of transforms.
[[nodiscard]] std::vector<PoleCandidate> filter_diagonalize(
    const EvenSeries& signal,
    const std::vector<Band>& bands_hz,
    const FilterDiagonalizationOptions& options = {});

}  // namespace twang
