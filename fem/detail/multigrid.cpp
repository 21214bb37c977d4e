// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/multigrid.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <utility>

namespace twang {
namespace {

constexpr int kThreadedNodes = 20'000;
constexpr int kSmoothingDegree = 3;
/// Errors with eigenvalues of D^-1 A above the largest over this are smoothed away.
constexpr float kSmoothedRange = 10.0F;
constexpr int kPowerIterations = 15;
/// What the power iteration falls short of the largest eigenvalue, generously.
constexpr float kSafety = 1.15F;
/// A level that saves less than this is not worth its while.
constexpr double kLeastCoarsening = 1.5;

/// Types of the finest cells: the body's, and held degrees of freedom.
TypedGrid typed_grid(const VoxelBody& body, std::vector<int>& body_type) {
  TypedGrid result;
  result.grid = body.grid();
  result.held = body.held();
  result.type.resize(result.grid.num_cells());
  const auto nodes = result.grid.nodes_of_cells();
  std::map<std::pair<int, std::uint32_t>, int> known;
  for (int c = 0; c < result.grid.num_cells(); ++c) {
    const int type = body.type_of_cell(c);
    const std::uint32_t mask = held_mask(result.held, result.grid.num_nodes(), nodes.col(c));
    const auto [at, added] = known.try_emplace({type, mask}, result.num_types);
    if (added) {
      ++result.num_types;
      body_type.push_back(type);
      result.held_of_type.push_back(mask);
    }
    result.type[c] = at->second;
  }
  return result;
}

}  // namespace

Multigrid::Multigrid(const VoxelBody& body, int max_coarse_dofs)
    : m_body(body), m_fine(typed_grid(body, m_type_of_fine)) {
  const TypedGrid* last = &m_fine;
  m_levels.emplace_back();
  m_levels.back().cells = last;
  while (last->num_free() > max_coarse_dofs) {
    auto coarse = std::make_unique<CoarseGrid>(*last);
    if (coarse->cells.num_free() == 0 ||
        coarse->cells.num_free() * kLeastCoarsening > last->num_free()) {
      break;
    }
    last = &coarse->cells;
    m_coarse.push_back(std::move(coarse));
    m_levels.emplace_back();
    m_levels.back().cells = last;
  }
  for (Level& level : m_levels) {
    for (Eigen::VectorXf* vector : {&level.x, &level.r, &level.step}) {
      vector->setZero(3 * level.num_nodes());
    }
  }
  m_coarsest_free.assign(last->held.size(), -1);
  // Node by node, as the factorization's ordering expects it.
  const int num_nodes = last->grid.num_nodes();
  for (int n = 0; n < num_nodes; ++n) {
    for (int a = 0; a < 3; ++a) {
      const auto dof = static_cast<std::size_t>(a * num_nodes + n);
      if (last->held[dof] == 0) m_coarsest_free[dof] = m_num_coarsest++;
    }
  }
}

SolveStatus Multigrid::prepare(const StiffnessCombination& of) {
  m_moduli = m_body.moduli<float>(of);
  m_solver.reset();
  std::vector<Eigen::MatrixXd> matrices = fine_matrices(of);
  for (std::size_t l = 0; l < m_levels.size(); ++l) {
    Level& level = m_levels[l];
    if (l > 0) {
      matrices = m_coarse[l - 1]->matrices(matrices);
      level.matrices.clear();
      level.matrices.reserve(576 * matrices.size());
      for (const Eigen::MatrixXd& matrix : matrices) {
        for (const double value : matrix.reshaped()) {
          level.matrices.push_back(static_cast<float>(value));
        }
      }
    }
    if (l + 1 == m_levels.size()) break;
    if (!invert_diagonal(level, matrices)) return SolveStatus::NotPositiveDefinite;
    level.largest = estimate_largest(level);
  }
  const SparseMatrix A = assemble_coarsest(matrices);
  auto solver = make_cholesky_solver();
  SolveStatus status = solver->analyze(A);
  if (status == SolveStatus::Ok) status = solver->factorize(A);
  if (status == SolveStatus::Ok) m_solver = std::move(solver);
  return status;
}

std::vector<Eigen::MatrixXd> Multigrid::fine_matrices(const StiffnessCombination& of) const {
  std::vector<Eigen::MatrixXd> matrices;
  for (std::size_t t = 0; t < m_type_of_fine.size(); ++t) {
    matrices.push_back(m_body.cell_matrix(of, m_type_of_fine[t]));
    zero_held(m_fine.held_of_type[t], matrices.back());
  }
  return matrices;
}

void Multigrid::add_product(const Level& level, float scale, const float* x, float* y) const {
  if (level.cells == &m_fine) return m_body.add_product(m_moduli, scale, x, y);
  const TypedGrid& cells = *level.cells;
  const std::ptrdiff_t nodes = level.num_nodes();
  cells.grid.for_each_row([&](const CellGrid::Row& from) {
    DenseRow row;
    row.length = from.length;
    for (int a = 0; a < 3; ++a) {
      for (int edge = 0; edge < 4; ++edge) {
        const auto at = a * nodes + from.first_node[static_cast<std::size_t>(edge)];
        row.x[a][edge] = x + at;
        row.y[a][edge] = y + at;
      }
    }
    row.type = cells.type.data() + from.first_cell;
    row.matrices = level.matrices.data();
    row.scale = scale;
    voxel_kernels().dense(row);
  });
}

bool Multigrid::invert_diagonal(Level& level, const std::vector<Eigen::MatrixXd>& matrices) {
  const TypedGrid& cells = *level.cells;
  const int num_nodes = level.num_nodes();
  Eigen::ArrayXXd diagonal = Eigen::ArrayXXd::Zero(num_nodes, 6);
  const auto nodes = cells.grid.nodes_of_cells();
  for (int c = 0; c < cells.grid.num_cells(); ++c) {
    const Eigen::MatrixXd& matrix = matrices[static_cast<std::size_t>(cells.type[c])];
    for (int n = 0; n < 8; ++n) {
      for (int a = 0, at = 0; a < 3; ++a) {
        for (int b = a; b < 3; ++b, ++at) {
          diagonal(nodes(n, c), at) += matrix(8 * a + n, 8 * b + n);
        }
      }
    }
  }
  level.inverse_diagonal.resize(num_nodes, 6);
  bool good = true;
  for (int n = 0; n < num_nodes; ++n) {
    Eigen::Matrix3d block;
    for (int a = 0, at = 0; a < 3; ++a) {
      for (int b = a; b < 3; ++b, ++at) block(a, b) = block(b, a) = diagonal(n, at);
      if (cells.held[static_cast<std::size_t>(a * num_nodes + n)] != 0) block(a, a) = 1.0;
    }
    const Eigen::LLT<Eigen::Matrix3d> factor(block);
    good = good && factor.info() == Eigen::Success;
    const Eigen::Matrix3d inverse = factor.solve(Eigen::Matrix3d::Identity());
    for (int a = 0, at = 0; a < 3; ++a) {
      for (int b = a; b < 3; ++b, ++at) {
        level.inverse_diagonal(n, at) = static_cast<float>(inverse(a, b));
      }
    }
  }
  return good && level.inverse_diagonal.isFinite().all();
}

/// Power iteration from a fixed start.
float Multigrid::estimate_largest(Level& level) const {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(-1.0F, 1.0F);
  Eigen::VectorXf& v = level.step;
  for (Eigen::Index i = 0; i < v.size(); ++i) {
    v[i] = level.cells->held[static_cast<std::size_t>(i)] != 0 ? 0.0F : uniform(random);
  }
  float largest = 1.0F;
  for (int k = 0; k < kPowerIterations; ++k) {
    level.step /= level.step.norm();
    level.r.setZero();
    add_product(level, 1.0F, level.step.data(), level.r.data());
    level.x.setZero();
    precondition_step(level, 0.0F, 1.0F);
    largest = level.step.norm();
  }
  return kSafety * largest;
}

/// step = keep step + add D^-1 r; x += step.
void Multigrid::precondition_step(Level& level, float keep, float add) const {
  const int n = level.num_nodes();
  const Eigen::ArrayXXf& inverse = level.inverse_diagonal;
  const float* r = level.r.data();
  float* step = level.step.data();
  float* x = level.x.data();
  const float *i00 = &inverse(0, 0), *i10 = &inverse(0, 1), *i20 = &inverse(0, 2);
  const float *i11 = &inverse(0, 3), *i21 = &inverse(0, 4), *i22 = &inverse(0, 5);
#pragma omp parallel for schedule(static) if (n > kThreadedNodes)
  for (int i = 0; i < n; ++i) {
    const float r0 = add * r[i];
    const float r1 = add * r[n + i];
    const float r2 = add * r[2 * n + i];
    const float s0 = keep * step[i] + i00[i] * r0 + i10[i] * r1 + i20[i] * r2;
    const float s1 = keep * step[n + i] + i10[i] * r0 + i11[i] * r1 + i21[i] * r2;
    const float s2 = keep * step[2 * n + i] + i20[i] * r0 + i21[i] * r1 + i22[i] * r2;
    step[i] = s0;
    step[n + i] = s1;
    step[2 * n + i] = s2;
    x[i] += s0;
    x[n + i] += s1;
    x[2 * n + i] += s2;
  }
}

/// Chebyshev smoothing of A x = b from x and r = b - A x, which is kept up to the last step, or
/// through it where it is wanted.
void Multigrid::smooth(Level& level, bool residual_wanted) const {
  const float high = level.largest;
  const float low = high / kSmoothedRange;
  const float middle = 0.5F * (high + low);
  const float half = 0.5F * (high - low);
  const float sigma = middle / half;
  float rho = 1.0F / sigma;
  precondition_step(level, 0.0F, 1.0F / middle);
  for (int k = 1; k < kSmoothingDegree; ++k) {
    add_product(level, -1.0F, level.step.data(), level.r.data());
    const float next = 1.0F / (2.0F * sigma - rho);
    precondition_step(level, next * rho, 2.0F * next / half);
    rho = next;
  }
  if (residual_wanted) add_product(level, -1.0F, level.step.data(), level.r.data());
}

void Multigrid::cycle_from(std::size_t index) {
  Level& level = m_levels[index];
  if (index + 1 == m_levels.size()) return cycle_coarsest(level);
  const CoarseGrid& coarse = *m_coarse[index];
  Level& next = m_levels[index + 1];
  level.x.setZero();
  smooth(level, true);
  coarse.restrict_to_coarse(*level.cells, level.r.data(), next.r.data());
  cycle_from(index + 1);
  coarse.prolong(*level.cells, next.x.data(), level.step.data());
  level.x += level.step;
  add_product(level, -1.0F, level.step.data(), level.r.data());
  smooth(level, false);
}

Eigen::VectorXd Multigrid::cycle(const Eigen::VectorXd& r) {
  // Scaled, lest it leave the range of single precision.
  const double scale = r.lpNorm<Eigen::Infinity>();
  if (!(scale > 0.0)) return Eigen::VectorXd::Zero(r.size());
  m_levels.front().r = (r / scale).cast<float>();
  cycle_from(0);
  return scale * m_levels.front().x.cast<double>();
}

SparseMatrix Multigrid::assemble_coarsest(const std::vector<Eigen::MatrixXd>& matrices) const {
  const TypedGrid& cells = *m_levels.back().cells;
  const int num_nodes = cells.grid.num_nodes();
  const auto nodes = cells.grid.nodes_of_cells();
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(576 * static_cast<std::size_t>(cells.grid.num_cells()));
  for (int c = 0; c < cells.grid.num_cells(); ++c) {
    const Eigen::MatrixXd& matrix = matrices[static_cast<std::size_t>(cells.type[c])];
    Eigen::Array<int, 24, 1> dofs;
    for (int i = 0; i < 24; ++i) {
      const auto dof = static_cast<std::size_t>(i / 8 * num_nodes + nodes(i % 8, c));
      dofs[i] = m_coarsest_free[dof];
    }
    for (int j = 0; j < 24; ++j) {
      for (int i = 0; i < 24; ++i) {
        if (dofs[i] >= 0 && dofs[j] >= 0) entries.emplace_back(dofs[i], dofs[j], matrix(i, j));
      }
    }
  }
  SparseMatrix A(m_num_coarsest, m_num_coarsest);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

SparseMatrix Multigrid::coarsest_matrix(const StiffnessCombination& of) const {
  std::vector<Eigen::MatrixXd> matrices = fine_matrices(of);
  for (const auto& coarse : m_coarse) matrices = coarse->matrices(matrices);
  return assemble_coarsest(matrices);
}

Eigen::VectorXd Multigrid::solve_coarsest(const Eigen::VectorXd& b) {
  Eigen::MatrixXd x;
  m_solver->solve(b, x);
  return x;
}

void Multigrid::set_coarsest(const Eigen::VectorXd& x) {
  Level& level = m_levels.back();
  for (std::size_t dof = 0; dof < m_coarsest_free.size(); ++dof) {
    const int at = m_coarsest_free[dof];
    level.x[static_cast<Eigen::Index>(dof)] = at < 0 ? 0.0F : static_cast<float>(x[at]);
  }
}

Eigen::VectorXd Multigrid::prolong_from_coarsest(const Eigen::VectorXd& x) {
  set_coarsest(x / x.lpNorm<Eigen::Infinity>());
  for (std::size_t l = m_levels.size() - 1; l > 0; --l) {
    Level& level = m_levels[l - 1];
    m_coarse[l - 1]->prolong(*level.cells, m_levels[l].x.data(), level.x.data());
  }
  return m_levels.front().x.cast<double>();
}

void Multigrid::cycle_coarsest(Level& level) {
  Eigen::VectorXd b(m_num_coarsest);
  for (std::size_t dof = 0; dof < m_coarsest_free.size(); ++dof) {
    if (m_coarsest_free[dof] < 0) continue;
    b[m_coarsest_free[dof]] = static_cast<double>(level.r[static_cast<Eigen::Index>(dof)]);
  }
  set_coarsest(solve_coarsest(b));
}

double Multigrid::memory_bytes() const {
  double bytes = 8.0 * 4.0 * static_cast<double>(m_body.grid().num_cells());
  for (const Level& level : m_levels) {
    bytes += 4.0 * static_cast<double>(level.matrices.capacity()) +
             (6.0 + 9.0) * 4.0 * level.num_nodes() + 3.0 * level.num_nodes() +
             (8.0 + 24.0) * level.num_nodes() + 28.0 * level.cells->grid.num_cells();
  }
  return bytes + estimate_factor_bytes(m_num_coarsest);
}

}  // namespace twang
