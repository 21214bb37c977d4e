// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/thread_limits.hpp"

#include "core/error.hpp"
#include "fem/threads.hpp"

#include <dlfcn.h>
#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <atomic>
#include <fstream>

namespace twang {
namespace {

/// OpenBLAS's own controls, if that is the BLAS in use: it is chosen when the program is loaded.
struct OpenBlas {
  int (*num_threads)() = nullptr;
  void (*set_num_threads)(int) = nullptr;
};

const OpenBlas& open_blas() {
  static const OpenBlas controls = {
      reinterpret_cast<int (*)()>(dlsym(RTLD_DEFAULT, "openblas_get_num_threads")),
      reinterpret_cast<void (*)(int)>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads")),
  };
  return controls;
}

enum class Threads { AsMachinePermits, OneForFactors, Fixed };
std::atomic<Threads> threads_now{Threads::AsMachinePermits};

}  // namespace

void fix_threads(int threads) {
  if (threads < 0)
    throw InputError(fmt::format("the number of threads is {}, must be >= 0", threads));
  threads_now = threads == 0 ? Threads::OneForFactors : Threads::Fixed;
  if (threads == 0) return;
  omp_set_num_threads(threads);
  if (open_blas().set_num_threads != nullptr) open_blas().set_num_threads(threads);
}

void for_each_range(int count, const std::function<void(int first, int last)>& work) {
  constexpr int kThreadedCount = 20'000;
  constexpr int kRange = 2048;
  if (count < kThreadedCount) {
    if (count > 0) work(0, count);
    return;
  }
  const PoliteThreads threads;
#pragma omp parallel for schedule(static)
  for (int first = 0; first < count; first += kRange) work(first, std::min(first + kRange, count));
}

bool machine_is_busy() {
  if (threads_now == Threads::Fixed) return false;
  // "0.20 0.18 0.12 1/80 11206": the fourth field is the number of tasks that could run now.
  std::ifstream file("/proc/loadavg");
  double average = 0.0;
  int runnable = 0;
  if (!(file >> average >> average >> average >> runnable)) return false;
  return runnable >= omp_get_num_procs();  // this task is one of them
}

ThreadLimits::ThreadLimits(bool single_blas) : m_active_levels(omp_get_max_active_levels()) {
  omp_set_max_active_levels(0);
  const OpenBlas& blas = open_blas();
  if (threads_now == Threads::OneForFactors) single_blas = true;
  if (!single_blas || blas.num_threads == nullptr || blas.set_num_threads == nullptr) return;
  m_blas_threads = blas.num_threads();
  blas.set_num_threads(1);
}

ThreadLimits::~ThreadLimits() {
  omp_set_max_active_levels(m_active_levels);
  if (m_blas_threads > 0) open_blas().set_num_threads(m_blas_threads);
}

PoliteThreads::PoliteThreads() : m_threads(omp_get_max_threads()) {
  if (m_threads > 1 && machine_is_busy()) omp_set_num_threads(1);
}

PoliteThreads::~PoliteThreads() { omp_set_num_threads(m_threads); }

}  // namespace twang
