// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/shift_invert_lanczos.hpp"

#include "fem/detail/thread_limits.hpp"

#include <arpack/arpack.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <numeric>
#include <random>
#include <vector>

namespace twang {
namespace {

constexpr int kMaxRestarts = 300;
constexpr int kShiftInvertMode = 3;
/// Basis vectors beyond the modes wanted; more or fewer cost more solves.
constexpr int kSpareVectors = 8;

/// ARPACK keeps its state in variables of its own: one iteration at a time.
std::mutex& arpack_mutex() {
  static std::mutex mutex;
  return mutex;
}

/// Two values that differ by less count as one eigenvalue [-].
constexpr double kSameLambda = 1e-6;
/// Of the search for eigenvalues that were passed over; its values are only compared [-].
constexpr double kSearchTolerance = 1e-4;
constexpr unsigned kStartSeed = 20170729;

/// A problem without its known vectors, and a start for the iteration.
class DeflatedProblem {
 public:
  DeflatedProblem(const ShiftedProblem& problem, unsigned seed)
      : m_problem(problem), m_mass_known(problem.size, problem.known.cols()) {
    for (int k = 0; k < problem.known.cols(); ++k) {
      m_mass_known.col(k) = problem.apply_mass(problem.known.col(k));
    }
    std::mt19937 generator(seed);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    m_start =
        project(Eigen::VectorXd::NullaryExpr(problem.size, [&]() { return uniform(generator); }));
  }
  [[nodiscard]] int size() const { return m_problem.size; }
  [[nodiscard]] double sigma() const { return m_problem.sigma; }
  [[nodiscard]] const Eigen::VectorXd& start() const { return m_start; }
  [[nodiscard]] Eigen::VectorXd apply_mass(const Eigen::VectorXd& x) const {
    return m_problem.apply_mass(x);
  }
  [[nodiscard]] Eigen::VectorXd apply_solver(const Eigen::VectorXd& x) const {
    return project(m_problem.apply_solver(x));
  }

 private:
  [[nodiscard]] Eigen::VectorXd project(Eigen::VectorXd x) const {
    if (m_mass_known.cols() > 0) x -= m_problem.known * (m_mass_known.transpose() * x);
    return x;
  }
  const ShiftedProblem& m_problem;
  Eigen::MatrixXd m_mass_known;
  Eigen::VectorXd m_start;
};

/// The arrays ARPACK works on.
struct Workspace {
  Workspace(int n, int count, Eigen::VectorXd start)
      : size(n),
        num_vectors(std::min(n, count + std::max(kSpareVectors, count / 2))),
        residual(std::move(start)),
        basis(n, num_vectors),
        workd(3 * static_cast<Eigen::Index>(n)),
        workl(static_cast<Eigen::Index>(num_vectors) * (num_vectors + 8)) {
    iparam[0] = 1;  // exact shifts
    iparam[2] = kMaxRestarts;
    iparam[6] = kShiftInvertMode;
  }
  int size;
  int num_vectors;
  Eigen::VectorXd residual;
  Eigen::MatrixXd basis;
  Eigen::VectorXd workd;
  Eigen::VectorXd workl;
  std::array<int, 11> iparam{};
  std::array<int, 14> ipntr{};
  int info = 1;  // the start vector is given

  [[nodiscard]] auto slot(std::size_t which) { return workd.segment(ipntr[which] - 1, size); }
};

void iterate(Workspace& work, const DeflatedProblem& problem, int count, double tolerance) {
  int request = 0;
  for (;;) {
    {
      const ThreadLimits limits(true);  // vectors alone: memory sets the pace
      dsaupd_c(&request,
               "G",
               work.size,
               "LM",
               count,
               tolerance,
               work.residual.data(),
               work.num_vectors,
               work.basis.data(),
               work.size,
               work.iparam.data(),
               work.ipntr.data(),
               work.workd.data(),
               work.workl.data(),
               static_cast<int>(work.workl.size()),
               &work.info);
    }
    if (request == -1) {
      work.slot(1) = problem.apply_solver(problem.apply_mass(work.slot(0)));
    } else if (request == 1) {
      work.slot(1) = problem.apply_solver(work.slot(2));  // M x is at hand
    } else if (request == 2) {
      work.slot(1) = problem.apply_mass(work.slot(0));
    } else {
      return;
    }
  }
}

LanczosResult sorted(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& vectors) {
  std::vector<int> order(static_cast<std::size_t>(lambda.size()));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return lambda[a] < lambda[b]; });
  LanczosResult result;
  result.lambda = lambda(order);
  result.vectors = vectors(Eigen::all, order);
  return result;
}

LanczosResult run_lanczos(const DeflatedProblem& problem, int count, double tolerance) {
  const std::lock_guard<std::mutex> lock(arpack_mutex());
  Workspace work(problem.size(), count, problem.start());
  iterate(work, problem, count, tolerance);
  LanczosResult failure;
  failure.termination =
      work.info == 1 ? Termination::IterationLimit : Termination::NumericalFailure;
  failure.message = fmt::format("the eigenvalue iteration found {} of {} modes (ARPACK dsaupd: {})",
                                work.iparam[4],
                                count,
                                work.info);
  if (work.info != 0 || work.iparam[4] < count) return failure;

  Eigen::VectorXd lambda(count);
  Eigen::MatrixXd vectors(problem.size(), count);
  const std::vector<int> select(static_cast<std::size_t>(work.num_vectors), 1);
  int info = 0;
  const ThreadLimits limits(true);
  dseupd_c(1,
           "A",
           select.data(),
           lambda.data(),
           vectors.data(),
           problem.size(),
           problem.sigma(),
           "G",
           problem.size(),
           "LM",
           count,
           tolerance,
           work.residual.data(),
           work.num_vectors,
           work.basis.data(),
           problem.size(),
           work.iparam.data(),
           work.ipntr.data(),
           work.workd.data(),
           work.workl.data(),
           static_cast<int>(work.workl.size()),
           &info);
  if (info != 0) {
    failure.termination = Termination::NumericalFailure;
    failure.message = fmt::format("the eigenvectors could not be formed (ARPACK dseupd: {})", info);
    return failure;
  }
  LanczosResult result = sorted(lambda, vectors);
  result.termination = Termination::Converged;
  return result;
}

Eigen::MatrixXd beside(const Eigen::MatrixXd& left, const Eigen::MatrixXd& right) {
  Eigen::MatrixXd both(left.rows(), left.cols() + right.cols());
  both << left, right;
  return both;
}

}  // namespace

LanczosResult find_smallest(const ShiftedProblem& problem, int count, double tolerance) {
  unsigned seed = kStartSeed;
  LanczosResult result = run_lanczos(DeflatedProblem(problem, seed), count, tolerance);
  while (result.termination == Termination::Converged) {
    ShiftedProblem rest = problem;
    rest.known = beside(problem.known, result.vectors);
    if (rest.known.cols() + 1 >= problem.size) break;
    const DeflatedProblem deflated(rest, ++seed);
    const LanczosResult search = run_lanczos(deflated, 1, kSearchTolerance);
    if (search.termination != Termination::Converged) return search;
    const double largest = result.lambda[count - 1];
    if (search.lambda[0] > largest - kSameLambda * std::abs(largest - problem.sigma)) break;
    const LanczosResult missed = run_lanczos(deflated, 1, tolerance);
    if (missed.termination != Termination::Converged) return missed;
    Eigen::VectorXd lambda(count + 1);
    lambda << result.lambda, missed.lambda;
    const LanczosResult all = sorted(lambda, beside(result.vectors, missed.vectors));
    result.lambda = all.lambda.head(count);
    result.vectors = all.vectors.leftCols(count);
  }
  return result;
}

}  // namespace twang
