// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/quadratic_cells.hpp"

#include <cblas.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace twang {
namespace {

constexpr int kNodes = 20;
constexpr int kDofs = 3 * kNodes;
/// Cells multiplied at once; so few that no BLAS starts threads of its own for them.
constexpr int kBatch = 48;
constexpr int kThreadedCells = 500;

/// The first element alone, of one material.
HexMesh single_element(const HexMesh& mesh) {
  HexMesh single;
  single.kind = ElementKind::Hex20;
  single.nodes.resize(3, kNodes);
  single.elements.resize(kNodes, 1);
  for (int n = 0; n < kNodes; ++n) {
    single.nodes.col(n) = mesh.nodes.col(mesh.elements(n, 0));
    single.elements(n, 0) = n;
  }
  single.material_of_element = {0};
  single.material_names = {"cell"};
  return single;
}

/// Parity of a cell's place along each axis: cells of one colour touch nowhere.
int colour_of(const HexMesh& mesh, const Eigen::Vector3d& origin, int element) {
  const Eigen::Vector3d low = mesh.nodes.col(mesh.elements(0, element));
  const Eigen::Vector3d size = mesh.nodes.col(mesh.elements(6, element)) - low;
  const Eigen::Array3d place = ((low - origin).cwiseQuotient(size)).array().round();
  int colour = 0;
  for (int a = 0; a < 3; ++a) colour |= (static_cast<int>(place[a]) & 1) << a;
  return colour;
}

/// Y = A X + keep Y, all (60 x count).
void multiply(const Eigen::MatrixXd& A, const double* X, double keep, double* Y, int count) {
  cblas_dgemm(CblasColMajor,
              CblasNoTrans,
              CblasNoTrans,
              kDofs,
              count,
              kDofs,
              1.0,
              A.data(),
              kDofs,
              X,
              kDofs,
              keep,
              Y,
              kDofs);
}
void multiply(const Eigen::MatrixXf& A, const float* X, float keep, float* Y, int count) {
  cblas_sgemm(CblasColMajor,
              CblasNoTrans,
              CblasNoTrans,
              kDofs,
              count,
              kDofs,
              1.0F,
              A.data(),
              kDofs,
              X,
              kDofs,
              keep,
              Y,
              kDofs);
}

}  // namespace

QuadraticCells::QuadraticCells(const ElasticBody& body) : m_num_nodes(body.mesh().num_nodes()) {
  const HexMesh& mesh = body.mesh();
  for (const ElasticMaterial& material : body.materials()) {
    const ElasticBody cell(single_element(mesh), {material}, ConstitutiveModel::Linear);
    m_materials.push_back({Eigen::MatrixXd(cell.stiffness({})),
                           Eigen::MatrixXd(cell.mass()),
                           material.damping_stiffness_b_s});
  }
  const Eigen::Vector3d origin = mesh.nodes.rowwise().minCoeff();
  const int num_cells = mesh.num_elements();
  std::vector<int> key(static_cast<std::size_t>(num_cells));
  const int num_materials = static_cast<int>(m_materials.size());
  for (int e = 0; e < num_cells; ++e) {
    const auto at = static_cast<std::size_t>(e);
    key[at] = colour_of(mesh, origin, e) * num_materials + mesh.material_of_element[at];
  }
  std::vector<int> order(key.size());
  std::iota(order.begin(), order.end(), 0);
  const auto key_of = [&](int e) { return key[static_cast<std::size_t>(e)]; };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return key_of(a) < key_of(b); });

  m_nodes.resize(kNodes, num_cells);
  if (mesh.stiffness_fill.size() > 0) m_stiffness_fill = mesh.stiffness_fill(order).array();
  if (mesh.mass_fill.size() > 0) m_mass_fill = mesh.mass_fill(order).array();
  int last_key = -1;
  for (int c = 0; c < num_cells; ++c) {
    const int element = order[static_cast<std::size_t>(c)];
    m_nodes.col(c) = mesh.elements.col(element);
    const int now = key_of(element);
    const bool new_colour = last_key < 0 || now / num_materials != last_key / num_materials;
    if (new_colour) m_colours.emplace_back();
    std::vector<Batch>& batches = m_colours.back();
    if (new_colour || now != last_key || batches.back().count == kBatch) {
      batches.push_back({c, 0, now % num_materials});
    }
    ++batches.back().count;
    last_key = now;
  }
}

template <class Real>
QuadraticCells::Matrices<Real> QuadraticCells::matrices(const StiffnessCombination& of) const {
  Matrices<Real> result;
  const bool stiff = of.stiffness != 0.0 || of.damping != 0.0;
  const bool apart = m_stiffness_fill.size() > 0 || m_mass_fill.size() > 0;
  for (const Material& material : m_materials) {
    Eigen::MatrixXd A = (of.stiffness + of.damping * material.damping_b) * material.stiffness;
    const Eigen::MatrixXd B = of.mass * material.mass;
    if (of.mass != 0.0 && !apart) A += B;
    if (stiff || !apart) result.stiff.push_back(A.template cast<Real>());
    if (of.mass != 0.0 && apart) result.mass.push_back(B.template cast<Real>());
  }
  return result;
}

template <class Real>
void QuadraticCells::add_product(const Matrices<Real>& A,
                                 Real scale,
                                 const Real* x,
                                 Real* y) const {
  for (const std::vector<Batch>& batches : m_colours) {
    const int count = static_cast<int>(batches.size());
#pragma omp parallel for schedule(static) if (count * kBatch > kThreadedCells)
    for (int b = 0; b < count; ++b) add_batch(A, batches[static_cast<std::size_t>(b)], scale, x, y);
  }
}

template <class Real>
void QuadraticCells::add_batch(
    const Matrices<Real>& A, const Batch& batch, Real scale, const Real* x, Real* y) const {
  alignas(64) Real X[kDofs * kBatch];
  alignas(64) Real Y[kDofs * kBatch];
  const auto material = static_cast<std::size_t>(batch.material);
  const std::ptrdiff_t stride = m_num_nodes;
  Real keep = 0;
  const auto multiply_filled = [&](const auto& matrices, const Eigen::ArrayXd& fill) {
    if (matrices.empty()) return;
    for (int c = 0; c < batch.count; ++c) {
      const int cell = batch.first + c;
      const Real part = fill.size() > 0 ? scale * static_cast<Real>(fill[cell]) : scale;
      Real* into = X + kDofs * c;
      for (int n = 0; n < kNodes; ++n) {
        const Real* from = x + m_nodes(n, cell);
        for (int a = 0; a < 3; ++a) into[3 * n + a] = part * from[a * stride];
      }
    }
    multiply(matrices[material], X, keep, Y, batch.count);
    keep = 1;
  };
  multiply_filled(A.stiff, m_stiffness_fill);
  multiply_filled(A.mass, m_mass_fill);
  if (keep == 0) return;
  for (int c = 0; c < batch.count; ++c) {
    const Real* from = Y + kDofs * c;
    for (int n = 0; n < kNodes; ++n) {
      Real* into = y + m_nodes(n, batch.first + c);
      for (int a = 0; a < 3; ++a) into[a * stride] += from[3 * n + a];
    }
  }
}

Eigen::ArrayXXd QuadraticCells::diagonal_blocks(const Matrices<double>& A) const {
  Eigen::ArrayXXd diagonal = Eigen::ArrayXXd::Zero(m_num_nodes, 6);
  const auto add = [&](const std::vector<Eigen::MatrixXd>& matrices,
                       const Eigen::ArrayXd& fill,
                       const Batch& batch) {
    if (matrices.empty()) return;
    const Eigen::MatrixXd& matrix = matrices[static_cast<std::size_t>(batch.material)];
    for (int c = batch.first; c < batch.first + batch.count; ++c) {
      const double part = fill.size() > 0 ? fill[c] : 1.0;
      for (int n = 0; n < kNodes; ++n) {
        for (int a = 0, at = 0; a < 3; ++a) {
          for (int b = a; b < 3; ++b, ++at) {
            diagonal(m_nodes(n, c), at) += part * matrix(3 * n + a, 3 * n + b);
          }
        }
      }
    }
  };
  for (const std::vector<Batch>& batches : m_colours) {
    for (const Batch& batch : batches) {
      add(A.stiff, m_stiffness_fill, batch);
      add(A.mass, m_mass_fill, batch);
    }
  }
  return diagonal;
}

template QuadraticCells::Matrices<double> QuadraticCells::matrices(
    const StiffnessCombination&) const;
template QuadraticCells::Matrices<float> QuadraticCells::matrices(
    const StiffnessCombination&) const;
template void QuadraticCells::add_product(const Matrices<double>&,
                                          double,
                                          const double*,
                                          double*) const;
template void QuadraticCells::add_product(const Matrices<float>&,
                                          float,
                                          const float*,
                                          float*) const;

}  // namespace twang
