// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/filter_diagonalization.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <fmt/format.h>

#include <algorithm>
#include <array>
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

BasisSums sum_basis(const VectorXd& c, Index m, Complex z) {
  BasisSums out;
  Complex power = 1.0;
  for (Index l = 0; l <= 2 * m; ++l) {
    if (l % 64 == 0) power = std::pow(z, static_cast<double>(l));  // stops round-off from growing
    const double weight = static_cast<double>(m - std::abs(m - l) + 1);
    for (std::size_t p = 0; p < 3; ++p) {
      const Complex term = c(l + static_cast<Index>(p)) * power;
      (l <= m ? out.f : out.g)[p] += term;
      out.diagonal[p] += weight * term;
    }
    power *= z;
  }
  return out;
}

BasisMatrices assemble(const VectorXd& c, Index m, const VectorXcd& z) {
  const Index size = z.size();
  std::vector<BasisSums> sums;
  BasisMatrices out;
  out.overlap.resize(size);
  VectorXcd z_power(size);  // z^(M+1)
  for (Index j = 0; j < size; ++j) {
    sums.push_back(sum_basis(c, m, z(j)));
    out.overlap(j) = sums.back().f[0];
    z_power(j) = std::polar(1.0, std::arg(z(j)) * static_cast<double>(m + 1));
  }
  for (std::size_t p = 0; p < 3; ++p) {
    out.u[p].resize(size, size);
    for (Index j = 0; j < size; ++j) {
      const BasisSums& sj = sums[static_cast<std::size_t>(j)];
      out.u[p](j, j) = sj.diagonal[p];
      for (Index k = 0; k < j; ++k) {
        const BasisSums& sk = sums[static_cast<std::size_t>(k)];
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

/// Solves U(1) B = u U(0) B in the span of the significant singular vectors of U(0).
void solve_window(const BasisMatrices& matrices,
                  const EvenSeries& signal,
                  const Band& window,
                  double rank_tolerance,
                  std::vector<PoleCandidate>& out) {
  const Eigen::BDCSVD<MatrixXcd> svd(matrices.u[0], Eigen::ComputeThinU | Eigen::ComputeThinV);
  const VectorXd& s = svd.singularValues();
  if (!(s(0) > 0.0) || !std::isfinite(s(0))) return;
  const Index rank = (s.array() > rank_tolerance * s(0)).count();
  const VectorXd root = s.head(rank).cwiseSqrt().cwiseInverse();
  const MatrixXcd left = root.asDiagonal() * svd.matrixU().leftCols(rank).adjoint();
  const MatrixXcd right = svd.matrixV().leftCols(rank) * root.asDiagonal();
  const Eigen::ComplexEigenSolver<MatrixXcd> eigen(left * matrices.u[1] * right);
  if (eigen.info() != Eigen::Success) return;
  for (Index i = 0; i < rank; ++i) {
    const Complex u = eigen.eigenvalues()(i);
    if (std::abs(u) < 1e-3) continue;
    const Complex log_u = std::log(u);
    const DampedPole pole{log_u.imag() / (kTwoPi * signal.step_s), -log_u.real() / signal.step_s};
    if (pole.frequency_hz < window.low_hz || pole.frequency_hz > window.high_hz) continue;
    const VectorXcd b = right * eigen.eigenvectors().col(i);
    const VectorXcd u0_b = matrices.u[0] * b;
    const Complex norm = b.cwiseProduct(u0_b).sum();  // bilinear: U is complex symmetric
    if (std::abs(norm) == 0.0) continue;
    const Complex projection = b.cwiseProduct(matrices.overlap).sum();
    const double error = (matrices.u[2] * b - u * u * u0_b).norm() / u0_b.norm();
    out.push_back({pole, 2.0 * std::abs(projection * projection / norm), error});
  }
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
  options.check();
  const double nyquist = 0.5 / signal.step_s;
  if (!(band_hz.low_hz >= 0.0 && band_hz.high_hz > band_hz.low_hz && band_hz.high_hz <= nyquist)) {
    throw InputError(fmt::format("band is {} to {} Hz, must be rising and within 0 to {} Hz",
                                 band_hz.low_hz,
                                 band_hz.high_hz,
                                 nyquist));
  }
  std::vector<PoleCandidate> found;
  const Index m = (signal.value.size() - 3) / 2;
  if (m < kMinBasis) return found;
  // The signal holds (M + 1) independent values; a band has its share of them.
  const double density = static_cast<double>(m + 1) * 2.0 * signal.step_s;  // basis per Hz
  const double width = band_hz.high_hz - band_hz.low_hz;
  const double usable = (1.0 - 2.0 * kOverlap) * options.max_basis / density;
  const int num_windows = std::max(1, static_cast<int>(std::ceil(width / usable)));
  const double inner = width / num_windows;
  for (int w = 0; w < num_windows; ++w) {
    const Band window{band_hz.low_hz + w * inner, band_hz.low_hz + (w + 1) * inner};
    const double margin = std::max(kOverlap * inner / (1.0 - 2.0 * kOverlap), kMinBasis / density);
    const double low = std::max(window.low_hz - margin, 0.0);
    const double high = std::min(window.high_hz + margin, nyquist);
    const Index size = std::clamp<Index>(
        static_cast<Index>(std::lround(density * (high - low))), kMinBasis, m + 1);
    VectorXcd z(size);
    for (Index j = 0; j < size; ++j) {
      const double phi =
          low + (high - low) * (static_cast<double>(j) + 0.5) / static_cast<double>(size);
      z(j) = std::polar(1.0, -kTwoPi * phi * signal.step_s);
    }
    solve_window(assemble(signal.value, m, z), signal, window, options.rank_tolerance, found);
  }
  std::sort(found.begin(), found.end(), [](const PoleCandidate& x, const PoleCandidate& y) {
    return x.amplitude > y.amplitude;
  });
  return found;
}

}  // namespace twang
