// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/fourier.hpp"

#include <fftw3.h>

#include <algorithm>
#include <memory>
#include <mutex>

namespace twang {
namespace {

struct FftwFree {
  void operator()(void* memory) const { fftw_free(memory); }
};

/// FFTW's planner is not reentrant.
std::mutex& planner_mutex() {
  static std::mutex mutex;
  return mutex;
}

}  // namespace

std::vector<std::complex<double>> fourier_transform(const Eigen::VectorXd& samples,
                                                    std::size_t length) {
  const std::unique_ptr<double, FftwFree> in(fftw_alloc_real(length));
  const std::size_t bins = length / 2 + 1;
  const std::unique_ptr<fftw_complex, FftwFree> out(fftw_alloc_complex(bins));
  const std::size_t used = std::min(length, static_cast<std::size_t>(samples.size()));
  std::copy_n(samples.data(), used, in.get());
  std::fill(in.get() + used, in.get() + length, 0.0);
  fftw_plan plan = nullptr;
  {
    const std::lock_guard<std::mutex> lock(planner_mutex());
    plan = fftw_plan_dft_r2c_1d(static_cast<int>(length), in.get(), out.get(), FFTW_ESTIMATE);
  }
  fftw_execute(plan);
  {
    const std::lock_guard<std::mutex> lock(planner_mutex());
    fftw_destroy_plan(plan);
  }
  std::vector<std::complex<double>> result(bins);
  for (std::size_t k = 0; k < bins; ++k) result[k] = {out.get()[k][0], out.get()[k][1]};
  return result;
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
