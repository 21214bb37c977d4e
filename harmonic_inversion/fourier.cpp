// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/fourier.hpp"

#include <fftw3.h>

#include <algorithm>
#include <mutex>

namespace twang {
namespace {

/// FFTW's planner is not reentrant.
std::mutex& planner_mutex() {
  static std::mutex mutex;
  return mutex;
}

}  // namespace

std::vector<std::complex<double>> fourier_transform(Eigen::VectorXd samples, std::size_t length) {
  // In place: FFTW takes the real samples from where it puts the complex bins.
  std::vector<std::complex<double>> bins(length / 2 + 1);
  auto* out = reinterpret_cast<fftw_complex*>(bins.data());
  auto* in = reinterpret_cast<double*>(bins.data());
  fftw_plan plan = nullptr;
  {
    const std::lock_guard<std::mutex> lock(planner_mutex());
    plan = fftw_plan_dft_r2c_1d(static_cast<int>(length), in, out, FFTW_ESTIMATE);
  }
  std::copy_n(samples.data(), std::min(length, static_cast<std::size_t>(samples.size())), in);
  samples.resize(0);  // a long record's memory
  fftw_execute(plan);
  {
    const std::lock_guard<std::mutex> lock(planner_mutex());
    fftw_destroy_plan(plan);
  }
  return bins;
}

std::size_t fast_length(std::size_t length) {
  for (std::size_t n = std::max<std::size_t>(length, 1);; ++n) {
    std::size_t rest = n;
    for (const std::size_t prime : {2U, 3U, 5U}) {
      while (rest % prime == 0) rest /= prime;
    }
    if (rest == 1) return n;
  }
}

}  // namespace twang
