// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/filter_diagonalization.hpp"

#include "core/constants.hpp"
#include "core/dense_algebra.hpp"
#include "core/error.hpp"
#include "harmonic_inversion/fourier.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <complex>

namespace twang {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

/// Windows overlap by this part on either side, so that a pole near a seam is inside one of them.
constexpr double kOverlap = 0.2;
/// Fewest basis functions that make a window worth solving.
constexpr int kMinBasis = 4;

/// From this length on FFTW plans powers of two much sooner than others.
constexpr std::size_t kLongGrid = 4096;

std::size_t grid_length(std::size_t least) {
  return least < kLongGrid ? fast_length(least) : std::bit_ceil(least);
}

/// U(p), p = 0, 1, 2, and the overlaps of the basis with the signal.
struct BasisMatrices {
  std::array<MatrixXcd, 3> u;
  VectorXcd overlap;  ///< sum_n c_n z_j^n, n = 0..M
};

/// F_p(z), G_p(z) and the diagonal of U(p) for one basis function.
struct BasisSums {
  std::array<Complex, 3> f{};
  std::array<Complex, 3> g{};
  std::array<Complex, 3> diagonal{};
};

/// The basis functions of a whole record: z = exp(-i 2 pi k / L) on the grid of a Fourier transform
/// of length L >= 2 M + 2, so that three transforms give the sums of all of them.
class BasisGrid {
 public:
  BasisGrid(const VectorXd& c, Index m)
      : m_c(c),
        m_m(m),
        m_length(static_cast<Index>(grid_length(static_cast<std::size_t>(2 * m + 2)))) {
    VectorXd weighted(2 * m + 1);
    for (Index l = 0; l <= 2 * m; ++l) {
      weighted(l) = static_cast<double>(m - std::abs(m - l) + 1) * c(l);
    }
    const auto length = static_cast<std::size_t>(m_length);
    m_first = fourier_transform(c.head(m + 1), length);
    m_second = fourier_transform(c.segment(m + 1, m), length);
    m_weighted = fourier_transform(weighted, length);
  }

  [[nodiscard]] Index length() const { return m_length; }

  /// z_k^n.
  [[nodiscard]] Complex power(Index k, Index n) const {
    const auto turns = static_cast<double>(k * n % m_length) / static_cast<double>(m_length);
    return std::polar(1.0, -kTwoPi * turns);
  }

  /// By shifting the samples under the sums:
  ///
  ///     z F_(p+1) = F_p - c_p + c_(M+1+p) z^(M+1)
  ///     z G_(p+1) = G_p - c_(M+1+p) z^(M+1) + c_(2M+1+p) z^(2M+1)
  ///     z U_(p+1) = U_p - F_p + G_p + c_(2M+1+p) z^(2M+1)             (diagonals)
  [[nodiscard]] BasisSums sums(Index k) const {
    const auto at = static_cast<std::size_t>(k);
    const Complex middle = power(k, m_m + 1);
    const Complex end = power(k, 2 * m_m + 1);
    const Complex back = power(k, m_length - 1);  // 1 / z
    BasisSums out;
    out.f[0] = m_first[at];
    out.g[0] = middle * m_second[at];
    out.diagonal[0] = m_weighted[at];
    for (std::size_t p = 0; p < 2; ++p) {
      const auto shift = static_cast<Index>(p);
      const Complex at_middle = m_c(m_m + 1 + shift) * middle;
      const Complex at_end = m_c(2 * m_m + 1 + shift) * end;
      out.f[p + 1] = back * (out.f[p] - m_c(shift) + at_middle);
      out.g[p + 1] = back * (out.g[p] - at_middle + at_end);
      out.diagonal[p + 1] = back * (out.diagonal[p] - out.f[p] + out.g[p] + at_end);
    }
    return out;
  }

  /// U(p) of the `size` functions from `first` on.
  [[nodiscard]] BasisMatrices assemble(Index first, Index size) const {
    std::vector<BasisSums> all;
    BasisMatrices out;
    out.overlap.resize(size);
    VectorXcd z(size);
    VectorXcd z_power(size);  // z^(M+1)
    for (Index j = 0; j < size; ++j) {
      all.push_back(sums(first + j));
      out.overlap(j) = all.back().f[0];
      z(j) = power(first + j, 1);
      z_power(j) = power(first + j, m_m + 1);
    }
    for (std::size_t p = 0; p < 3; ++p) {
      out.u[p].resize(size, size);
      for (Index j = 0; j < size; ++j) {
        const BasisSums& sj = all[static_cast<std::size_t>(j)];
        out.u[p](j, j) = sj.diagonal[p];
        for (Index k = 0; k < j; ++k) {
          const BasisSums& sk = all[static_cast<std::size_t>(k)];
          const Complex a = z(j);
          const Complex b = z(k);
          // b^-M = b / b^(M+1), and so for a.
          const Complex value = (a * sj.f[p] - b * sk.f[p] + z_power(j) * b / z_power(k) * sk.g[p] -
                                 z_power(k) * a / z_power(j) * sj.g[p]) /
                                (a - b);
          out.u[p](j, k) = value;
          out.u[p](k, j) = value;
        }
      }
    }
    return out;
  }

 private:
  const VectorXd& m_c;
  Index m_m;
  Index m_length;
  std::vector<Complex> m_first;     ///< sum_{l = 0..M} c_l z^l
  std::vector<Complex> m_second;    ///< sum_{l = 0..M-1} c_(M+1+l) z^l
  std::vector<Complex> m_weighted;  ///< the diagonal of U(0)
};

/// Solves U(1) B = u U(0) B in the span of the significant singular vectors of U(0).
void solve_window(const BasisMatrices& matrices,
                  const EvenSeries& signal,
                  const Band& window,
                  double rank_tolerance,
                  std::vector<PoleCandidate>& out) {
  const auto svd = thin_svd(matrices.u[0]);
  if (!svd || !(svd->s(0) > 0.0)) return;
  const VectorXd& s = svd->s;
  const Index rank = (s.array() > rank_tolerance * s(0)).count();
  const VectorXd root = s.head(rank).cwiseSqrt().cwiseInverse();
  const MatrixXcd left = root.asDiagonal() * svd->u.leftCols(rank).adjoint();
  const MatrixXcd right = svd->v.leftCols(rank) * root.asDiagonal();
  const auto eigen = eigenpairs(left * matrices.u[1] * right);
  if (!eigen) return;
  for (Index i = 0; i < rank; ++i) {
    const Complex u = eigen->values(i);
    if (std::abs(u) < 1e-3) continue;
    const Complex log_u = std::log(u);
    const DampedPole pole{log_u.imag() / (kTwoPi * signal.step_s), -log_u.real() / signal.step_s};
    if (pole.frequency_hz < window.low_hz || pole.frequency_hz > window.high_hz) continue;
    const VectorXcd b = right * eigen->vectors.col(i);
    const VectorXcd u0_b = matrices.u[0] * b;
    const Complex norm = b.cwiseProduct(u0_b).sum();  // bilinear: U is complex symmetric
    if (std::abs(norm) == 0.0) continue;
    const Complex projection = b.cwiseProduct(matrices.overlap).sum();
    const double error = (matrices.u[2] * b - u * u * u0_b).norm() / u0_b.norm();
    out.push_back({pole, 2.0 * std::abs(projection * projection / norm), error});
  }
}

/// Cuts a band into overlapping windows of few enough basis functions and solves each.
void solve_band(const BasisGrid& grid,
                const EvenSeries& signal,
                const Band& band_hz,
                const FilterDiagonalizationOptions& options,
                std::vector<PoleCandidate>& found) {
  const double density = static_cast<double>(grid.length()) * signal.step_s;  // basis per Hz
  const Index highest = (grid.length() - 1) / 2;
  const double width = band_hz.high_hz - band_hz.low_hz;
  const double usable = (1.0 - 2.0 * kOverlap) * options.max_basis / density;
  const int num_windows = std::max(1, static_cast<int>(std::ceil(width / usable)));
  const double inner = width / num_windows;
  for (int w = 0; w < num_windows; ++w) {
    const Band window{band_hz.low_hz + w * inner, band_hz.low_hz + (w + 1) * inner};
    const double margin = std::max(kOverlap * inner / (1.0 - 2.0 * kOverlap), kMinBasis / density);
    const auto low = static_cast<Index>(std::ceil((window.low_hz - margin) * density));
    const auto high = static_cast<Index>(std::floor((window.high_hz + margin) * density));
    const Index first = std::clamp<Index>(low, 1, highest - kMinBasis + 1);
    const Index size = std::clamp<Index>(high, first + kMinBasis - 1, highest) - first + 1;
    solve_window(grid.assemble(first, size), signal, window, options.rank_tolerance, found);
  }
}

void check_band(const Band& band_hz, double nyquist_hz) {
  if (band_hz.low_hz >= 0.0 && band_hz.high_hz > band_hz.low_hz && band_hz.high_hz <= nyquist_hz)
    return;
  throw InputError(fmt::format("band is {} to {} Hz, must be rising and within 0 to {} Hz",
                               band_hz.low_hz,
                               band_hz.high_hz,
                               nyquist_hz));
}

}  // namespace

void FilterDiagonalizationOptions::check() const {
  if (max_basis < kMinBasis) {
    throw InputError(fmt::format(
        "FilterDiagonalizationOptions.max_basis is {}, must be at least {}", max_basis, kMinBasis));
  }
  if (!(rank_tolerance > 0.0 && rank_tolerance < 1.0)) {
    throw InputError(
        fmt::format("FilterDiagonalizationOptions.rank_tolerance is {}, must be within (0, 1)",
                    rank_tolerance));
  }
}

std::vector<PoleCandidate> filter_diagonalize(const EvenSeries& signal,
                                              const Band& band_hz,
                                              const FilterDiagonalizationOptions& options) {
  return filter_diagonalize(signal, std::vector<Band>{band_hz}, options);
}

std::vector<PoleCandidate> filter_diagonalize(const EvenSeries& signal,
                                              const std::vector<Band>& bands_hz,
                                              const FilterDiagonalizationOptions& options) {
  options.check();
  for (const Band& band : bands_hz) check_band(band, 0.5 / signal.step_s);
  std::vector<PoleCandidate> found;
  const Index m = (signal.value.size() - 3) / 2;
  if (m < kMinBasis) return found;
  const BasisGrid grid(signal.value, m);
  for (const Band& band : bands_hz) solve_band(grid, signal, band, options, found);
  std::sort(found.begin(), found.end(), [](const PoleCandidate& x, const PoleCandidate& y) {
    return x.amplitude > y.amplitude;
  });
  return found;
}

}  // namespace twang
