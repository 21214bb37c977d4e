// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/fourier.hpp"

#include <fftw3.h>

#include <algorithm>
#include <memory>
#include <mutex>
#include <type_traits>

namespace twang {
namespace {

/// FFTW's planner is not reentrant.
std::mutex& planner_mutex() {
  static std::mutex mutex;
  return mutex;
}

struct DestroyPlan {
  void operator()(fftw_plan plan) const {
    const std::lock_guard<std::mutex> lock(planner_mutex());
    fftw_destroy_plan(plan);
  }
};
using Plan = std::unique_ptr<std::remove_pointer_t<fftw_plan>, DestroyPlan>;

/// A plan in place: FFTW takes the real samples from where it puts the complex bins.
Plan make_plan(std::size_t length, fftw_complex* bins) {
  const std::lock_guard<std::mutex> lock(planner_mutex());
  return Plan(fftw_plan_dft_r2c_1d(
      static_cast<int>(length), reinterpret_cast<double*>(bins), bins, FFTW_ESTIMATE));
}

/// Plans that a thread keeps, for a plan takes longer to make than to carry out. Their tables take
/// memory, so the oldest are let go.
class KeptPlans {
 public:
  [[nodiscard]] fftw_plan plan(std::size_t length, fftw_complex* bins) {
    const int alignment = fftw_alignment_of(reinterpret_cast<double*>(bins));
    for (const Entry& entry : m_entries) {
      if (entry.length == length && entry.alignment == alignment) return entry.plan.get();
    }
    std::size_t together = length;
    for (const Entry& entry : m_entries) together += entry.length;
    while (together > kMostTogether && !m_entries.empty()) {
      together -= m_entries.front().length;
      m_entries.erase(m_entries.begin());
    }
    m_entries.push_back({length, alignment, make_plan(length, bins)});
    return m_entries.back().plan.get();
  }

 private:
  static constexpr std::size_t kMostTogether = std::size_t{5} << 19U;
  struct Entry {
    std::size_t length = 0;
    int alignment = 0;  // as FFTW counts it: a plan is good for arrays of the same
    Plan plan;
  };
  std::vector<Entry> m_entries;
};

}  // namespace

std::vector<std::complex<double>> fourier_transform(Eigen::VectorXd samples, std::size_t length) {
  std::vector<std::complex<double>> bins(length / 2 + 1);
  auto* out = reinterpret_cast<fftw_complex*>(bins.data());
  auto* in = reinterpret_cast<double*>(bins.data());
  std::copy_n(samples.data(), std::min(length, static_cast<std::size_t>(samples.size())), in);
  samples.resize(0);  // a long record's memory
  static thread_local KeptPlans plans;
  fftw_execute_dft_r2c(plans.plan(length, out), in, out);
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
