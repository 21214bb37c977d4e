// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/chebyshev_smoother.hpp"

#include <Eigen/Cholesky>

#include <cstddef>
#include <random>

namespace twang {
namespace {

constexpr int kThreadedNodes = 20'000;
constexpr int kPowerIterations = 15;
/// What the power iteration falls short of the largest eigenvalue, generously.
constexpr float kSafety = 1.15F;

}  // namespace

ChebyshevSmoother::ChebyshevSmoother(int num_nodes, Smoothing smoothing)
    : m_num_nodes(num_nodes), m_smoothing(smoothing) {
  for (Eigen::VectorXf* vector : {&x, &r, &step}) vector->setZero(3 * num_nodes);
}

bool ChebyshevSmoother::prepare(const Eigen::ArrayXXd& diagonal_blocks,
                                const std::vector<char>& held,
                                const Product& add_product) {
  if (!invert_diagonal(diagonal_blocks, held)) return false;
  estimate_largest(held, add_product);
  return true;
}

bool ChebyshevSmoother::invert_diagonal(const Eigen::ArrayXXd& diagonal,
                                        const std::vector<char>& held) {
  m_inverse_diagonal.resize(m_num_nodes, 6);
  bool good = true;
  for (int n = 0; n < m_num_nodes; ++n) {
    Eigen::Matrix3d block;
    for (int a = 0, at = 0; a < 3; ++a) {
      for (int b = a; b < 3; ++b, ++at) block(a, b) = block(b, a) = diagonal(n, at);
    }
    for (int a = 0; a < 3; ++a) {
      if (held[static_cast<std::size_t>(a * m_num_nodes + n)] == 0) continue;
      block.row(a).setZero();
      block.col(a).setZero();
      block(a, a) = 1.0;
    }
    const Eigen::LLT<Eigen::Matrix3d> factor(block);
    good = good && factor.info() == Eigen::Success;
    const Eigen::Matrix3d inverse = factor.solve(Eigen::Matrix3d::Identity());
    for (int a = 0, at = 0; a < 3; ++a) {
      for (int b = a; b < 3; ++b, ++at) {
        m_inverse_diagonal(n, at) = static_cast<float>(inverse(a, b));
      }
    }
  }
  return good && m_inverse_diagonal.isFinite().all();
}

/// Power iteration from a fixed start.
void ChebyshevSmoother::estimate_largest(const std::vector<char>& held,
                                         const Product& add_product) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(-1.0F, 1.0F);
  for (Eigen::Index i = 0; i < step.size(); ++i) {
    step[i] = held[static_cast<std::size_t>(i)] != 0 ? 0.0F : uniform(random);
  }
  float largest = 1.0F;
  for (int k = 0; k < kPowerIterations; ++k) {
    step /= step.norm();
    r.setZero();
    add_product(1.0F, step.data(), r.data());
    x.setZero();
    precondition_step(0.0F, 1.0F);
    largest = step.norm();
  }
  m_largest = kSafety * largest;
}

/// step = keep step + add D^-1 r; x += step.
void ChebyshevSmoother::precondition_step(float keep, float add) {
  const int n = m_num_nodes;
  const Eigen::ArrayXXf& inverse = m_inverse_diagonal;
  const float* residual = r.data();
  float* by = step.data();
  float* at = x.data();
  const float *i00 = &inverse(0, 0), *i10 = &inverse(0, 1), *i20 = &inverse(0, 2);
  const float *i11 = &inverse(0, 3), *i21 = &inverse(0, 4), *i22 = &inverse(0, 5);
#pragma omp parallel for schedule(static) if (n > kThreadedNodes)
  for (int i = 0; i < n; ++i) {
    const float r0 = add * residual[i];
    const float r1 = add * residual[n + i];
    const float r2 = add * residual[2 * n + i];
    const float s0 = keep * by[i] + i00[i] * r0 + i10[i] * r1 + i20[i] * r2;
    const float s1 = keep * by[n + i] + i10[i] * r0 + i11[i] * r1 + i21[i] * r2;
    const float s2 = keep * by[2 * n + i] + i20[i] * r0 + i21[i] * r1 + i22[i] * r2;
    by[i] = s0;
    by[n + i] = s1;
    by[2 * n + i] = s2;
    at[i] += s0;
    at[n + i] += s1;
    at[2 * n + i] += s2;
  }
}

void ChebyshevSmoother::smooth(const Product& add_product, bool residual_wanted) {
  const float high = m_largest;
  const float low = high / m_smoothing.range;
  const float middle = 0.5F * (high + low);
  const float half = 0.5F * (high - low);
  const float sigma = middle / half;
  float rho = 1.0F / sigma;
  precondition_step(0.0F, 1.0F / middle);
  for (int k = 1; k < m_smoothing.degree; ++k) {
    add_product(-1.0F, step.data(), r.data());
    const float next = 1.0F / (2.0F * sigma - rho);
    precondition_step(next * rho, 2.0F * next / half);
    rho = next;
  }
  if (residual_wanted) add_product(-1.0F, step.data(), r.data());
}

}  // namespace twang
