// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace twang {

/// Whether other processes want the processors now, so that threads of ours would wait for each
/// other: a factorization with two threads on a busy machine takes three times as long as with one.
/// false where the system does not tell.
[[nodiscard]] bool machine_is_busy();

/// While it lives, calls to CHOLMOD open no OpenMP regions (they cost more than they give, its
/// dense kernels have the threads of the BLAS), and with `single_blas` those kernels run in one
/// thread too: right for small matrices, where waking a second one costs more than the work.
class ThreadLimits {
 public:
  explicit ThreadLimits(bool single_blas);
  ~ThreadLimits();
  ThreadLimits(const ThreadLimits&) = delete;
  ThreadLimits& operator=(const ThreadLimits&) = delete;

 private:
  int m_active_levels = 1;
  int m_blas_threads = 0;  ///< to go back to; 0: left alone
};

/// While it lives, OpenMP regions opened by this thread run in one thread if the machine is busy.
class PoliteThreads {
 public:
  PoliteThreads();
  ~PoliteThreads();
  PoliteThreads(const PoliteThreads&) = delete;
  PoliteThreads& operator=(const PoliteThreads&) = delete;

 private:
  int m_threads = 1;  ///< to go back to
};

}  // namespace twang
