// SPDX-License-Identifier: GPL-3.0-or-later
// Included by one source file for each instruction set, which defines TWANG_KERNEL_NAMESPACE. Only
// functions of that namespace are compiled here, so that no inline function of a library is emitted
// with instructions the machine may lack.
#include "fem/detail/element_kernels.hpp"

#include <math.h>

namespace twang::TWANG_KERNEL_NAMESPACE {
namespace {

#define TWANG_INLINE inline __attribute__((always_inline))

typedef double Vec __attribute__((vector_size(8 * kLanes)));
typedef double UnalignedVec __attribute__((vector_size(8 * kLanes), aligned(8), may_alias));

TWANG_INLINE void load(const double* lanes, Vec& value) {
  value = *reinterpret_cast<const UnalignedVec*>(lanes);
}
TWANG_INLINE void store(double* lanes, const Vec& value) {
  *reinterpret_cast<UnalignedVec*>(lanes) = value;
}

/// A 3 x 3 matrix in every lane.
struct Mat3 {
  Vec m[3][3];
};

/// Of the points the first carry mu and the last lambda; where not split, all carry both.
template <int N, int G, int Split = 0>
struct Size {
  static constexpr int nodes = N;
  static constexpr int points = G;
  static constexpr int split = Split;
};
using Hex8 = Size<8, 8>;
using Hex20 = Size<20, 27>;
using Hex8e = Size<11, 14, 8>;  ///< eight nodes and three internal modes that move as nodes do

/// dN/dx and weights; broadcast where the elements are congruent.
template <class Element, bool Congruent>
struct Geometry;
template <class Element>
struct Geometry<Element, true> {
  using Scalar = double;
  const double* gradients;
  const double* weights;
  TWANG_INLINE void gradient(int g, int a, int i, double& value) const {
    value = gradients[(g * Element::nodes + a) * 3 + i];
  }
  TWANG_INLINE void weight(int g, double& value) const { value = weights[g]; }
};
template <class Element>
struct Geometry<Element, false> {
  using Scalar = Vec;
  const double* gradients;
  const double* weights;
  TWANG_INLINE void gradient(int g, int a, int i, Vec& value) const {
    load(gradients + ((g * Element::nodes + a) * 3 + i) * kLanes, value);
  }
  TWANG_INLINE void weight(int g, Vec& value) const { load(weights + g * kLanes, value); }
};

/// Lamé's constants of a batch at point g.
template <class Element>
TWANG_INLINE void load_moduli(const ElementBatch& batch, int g, Vec& mu, Vec& lambda) {
  mu = lambda = Vec{};
  if (Element::split == 0 || g < Element::split) load(batch.mu, mu);
  if (g >= Element::split) load(batch.lambda, lambda);
}

/// sum_a field_a ⊗ dN_a/dx at point g.
template <class Element, bool Congruent>
TWANG_INLINE void field_gradient(const Geometry<Element, Congruent>& geometry,
                                 int g,
                                 const double* field,
                                 Mat3& H) {
  H = Mat3{};
  for (int a = 0; a < Element::nodes; ++a) {
    typename Geometry<Element, Congruent>::Scalar dN[3];
    for (int j = 0; j < 3; ++j) geometry.gradient(g, a, j, dN[j]);
    for (int i = 0; i < 3; ++i) {
      Vec value;
      load(field + (3 * a + i) * kLanes, value);
      for (int j = 0; j < 3; ++j) H.m[i][j] += value * dN[j];
    }
  }
}

/// force_a += w P dN_a/dx
template <class Element, bool Congruent>
TWANG_INLINE void add_divergence(const Geometry<Element, Congruent>& geometry,
                                 int g,
                                 const Mat3& P,
                                 double* force) {
  typename Geometry<Element, Congruent>::Scalar weight;
  geometry.weight(g, weight);
  Mat3 scaled;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) scaled.m[i][j] = P.m[i][j] * weight;
  }
  for (int a = 0; a < Element::nodes; ++a) {
    typename Geometry<Element, Congruent>::Scalar dN[3];
    for (int j = 0; j < 3; ++j) geometry.gradient(g, a, j, dN[j]);
    for (int i = 0; i < 3; ++i) {
      Vec sum;
      load(force + (3 * a + i) * kLanes, sum);
      for (int j = 0; j < 3; ++j) sum += scaled.m[i][j] * dN[j];
      store(force + (3 * a + i) * kLanes, sum);
    }
  }
}

TWANG_INLINE void multiply(const Mat3& A, const Mat3& B, Mat3& product) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      product.m[i][j] = A.m[i][0] * B.m[0][j] + A.m[i][1] * B.m[1][j] + A.m[i][2] * B.m[2][j];
    }
  }
}

/// Cofactors of A: det(A) A^-T.
TWANG_INLINE void cofactors(const Mat3& A, Mat3& C) {
  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3;
    const int i2 = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3;
      const int j2 = (j + 2) % 3;
      C.m[i][j] = A.m[i1][j1] * A.m[i2][j2] - A.m[i1][j2] * A.m[i2][j1];
    }
  }
}

TWANG_INLINE void add_identity(const Mat3& H, Mat3& F) {
  F = H;
  for (int i = 0; i < 3; ++i) F.m[i][i] += 1.0;
}

/// ln(1 + x) and ln(1 + x) - x without cancellation. With s = x / (2 + x),
/// ln(1 + x) = 2 atanh(s) = 2 (s + s³/3 + s⁵/5 + ...) and 2 s - x = -s x.
TWANG_INLINE void log_one_plus(const Vec& x, Vec& log, Vec& log_minus_x) {
  constexpr double kSeriesRange = 0.25;  // there s² < 0.0205, so the first term left out is < 1e-17
  bool series = true;
  for (int lane = 0; lane < kLanes; ++lane) series = series && fabs(x[lane]) < kSeriesRange;
  if (series) {
    const Vec s = x / (2.0 + x);
    const Vec s2 = s * s;
    Vec sum = s2 * (1.0 / 21.0) + 1.0 / 19.0;
    sum = sum * s2 + 1.0 / 17.0;
    sum = sum * s2 + 1.0 / 15.0;
    sum = sum * s2 + 1.0 / 13.0;
    sum = sum * s2 + 1.0 / 11.0;
    sum = sum * s2 + 1.0 / 9.0;
    sum = sum * s2 + 1.0 / 7.0;
    sum = sum * s2 + 1.0 / 5.0;
    sum = sum * s2 + 1.0 / 3.0;
    const Vec tail = 2.0 * s * s2 * sum;
    log = 2.0 * s + tail;
    log_minus_x = tail - s * x;
    return;
  }
  for (int lane = 0; lane < kLanes; ++lane) {
    log[lane] = log1p(x[lane]);
    log_minus_x[lane] = log[lane] - x[lane];
  }
}

/// Second and third invariant of H and J - 1, without the cancellation of det(F) - 1.
struct Volume {
  Vec second;       ///< (tr(H)² - tr(H²)) / 2
  Vec third;        ///< det(H)
  Vec j_minus_one;  ///< tr(H) + second + third
};
TWANG_INLINE void volume_change(const Mat3& H, Volume& volume) {
  Mat3 C;
  cofactors(H, C);
  volume.second = C.m[0][0] + C.m[1][1] + C.m[2][2];
  volume.third = H.m[0][0] * C.m[0][0] + H.m[0][1] * C.m[0][1] + H.m[0][2] * C.m[0][2];
  volume.j_minus_one = H.m[0][0] + H.m[1][1] + H.m[2][2] + volume.second + volume.third;
}

/// F^-T and ln J.
TWANG_INLINE void invert(const Mat3& H, Mat3& inverse_transpose, Vec& log_j) {
  Volume volume;
  volume_change(H, volume);
  Vec unused;
  log_one_plus(volume.j_minus_one, log_j, unused);
  Mat3 F;
  add_identity(H, F);
  cofactors(F, inverse_transpose);
  const Vec scale = 1.0 / (1.0 + volume.j_minus_one);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) inverse_transpose.m[i][j] *= scale;
  }
}

/// 2 mu e + lambda tr(e) I for a symmetric e.
TWANG_INLINE void isotropic_stress(const Vec& mu, const Vec& lambda, const Mat3& e, Mat3& stress) {
  const Vec pressure = lambda * (e.m[0][0] + e.m[1][1] + e.m[2][2]);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) stress.m[i][j] = 2.0 * mu * e.m[i][j];
    stress.m[i][i] += pressure;
  }
}

TWANG_INLINE void isotropic_energy(const Vec& mu, const Vec& lambda, const Mat3& e, Vec& energy) {
  Vec norm2 = {};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) norm2 += e.m[i][j] * e.m[i][j];
  }
  const Vec trace = e.m[0][0] + e.m[1][1] + e.m[2][2];
  energy = mu * norm2 + 0.5 * lambda * trace * trace;
}

TWANG_INLINE void symmetric_part(const Mat3& H, Mat3& e) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) e.m[i][j] = 0.5 * (H.m[i][j] + H.m[j][i]);
  }
}

/// (H + H' + H'H) / 2
TWANG_INLINE void green_strain(const Mat3& H, Mat3& E) {
  symmetric_part(H, E);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      E.m[i][j] += 0.5 * (H.m[0][i] * H.m[0][j] + H.m[1][i] * H.m[1][j] + H.m[2][i] * H.m[2][j]);
    }
  }
}

#include "fem/detail/element_models_impl.hpp"

template <class Element, class Model, bool Congruent>
void energy_kernel(const ElementBatch& batch, double* result) {
  const Geometry<Element, Congruent> geometry{batch.geometry.gradients, batch.geometry.weights};
  Vec sum = {};
  for (int g = 0; g < Element::points; ++g) {
    Mat3 H;
    Vec mu, lambda, density;
    load_moduli<Element>(batch, g, mu, lambda);
    field_gradient(geometry, g, batch.u, H);
    Model::energy(mu, lambda, H, density);
    typename Geometry<Element, Congruent>::Scalar weight;
    geometry.weight(g, weight);
    sum += density * weight;
  }
  store(result, sum);
}

template <class Element, class Model, bool Congruent>
void force_kernel(const ElementBatch& batch, double* result) {
  const Geometry<Element, Congruent> geometry{batch.geometry.gradients, batch.geometry.weights};
  for (int i = 0; i < 3 * Element::nodes * kLanes; ++i) result[i] = 0.0;
  for (int g = 0; g < Element::points; ++g) {
    Mat3 H, P;
    Vec mu, lambda;
    load_moduli<Element>(batch, g, mu, lambda);
    field_gradient(geometry, g, batch.u, H);
    Model::stress(mu, lambda, H, P);
    add_divergence(geometry, g, P, result);
  }
}

template <class Element, class Model, bool Congruent>
void product_kernel(const ElementBatch& batch, double* result) {
  const Geometry<Element, Congruent> geometry{batch.geometry.gradients, batch.geometry.weights};
  for (int i = 0; i < 3 * Element::nodes * kLanes; ++i) result[i] = 0.0;
  for (int g = 0; g < Element::points; ++g) {
    Mat3 H = {}, dF, dP;
    Vec mu, lambda;
    load_moduli<Element>(batch, g, mu, lambda);
    if (!Model::is_linear) field_gradient(geometry, g, batch.u, H);
    field_gradient(geometry, g, batch.w, dF);
    Model::differential(mu, lambda, H, dF, dP);
    add_divergence(geometry, g, dP, result);
  }
}

/// Tables that let the sum over points of a node pair's block run in registers.
template <class Element>
struct TangentTables {
  Vec p[Element::nodes][Element::points][3];
  Vec first_p[Element::nodes][Element::points][3];
  Vec second_p[Element::nodes][Element::points][3];
  Vec stress_dN[Element::nodes][Element::points][3];
  Mat3 left[Element::points];
};

template <class Element, class Model, bool Congruent>
TWANG_INLINE void fill_tables(const Geometry<Element, Congruent>& geometry,
                              const ElementBatch& batch,
                              TangentTables<Element>& tables) {
  for (int g = 0; g < Element::points; ++g) {
    Mat3 H = {};
    Vec mu, lambda;
    load_moduli<Element>(batch, g, mu, lambda);
    if (!Model::is_linear) field_gradient(geometry, g, batch.u, H);
    typename Geometry<Element, Congruent>::Scalar weight;
    geometry.weight(g, weight);
    PointTangent point;
    Model::tangent(mu * weight, lambda * weight, H, point);
    if constexpr (Model::has_left_tensor) tables.left[g] = point.B;
    for (int a = 0; a < Element::nodes; ++a) {
      typename Geometry<Element, Congruent>::Scalar dN[3];
      for (int j = 0; j < 3; ++j) geometry.gradient(g, a, j, dN[j]);
      for (int i = 0; i < 3; ++i) {
        const Vec p = point.T.m[i][0] * dN[0] + point.T.m[i][1] * dN[1] + point.T.m[i][2] * dN[2];
        tables.p[a][g][i] = p;
        tables.first_p[a][g][i] = point.first * p;
        tables.second_p[a][g][i] = point.second * p;
        tables.stress_dN[a][g][i] =
            point.S.m[i][0] * dN[0] + point.S.m[i][1] * dN[1] + point.S.m[i][2] * dN[2];
      }
    }
  }
}

template <class Element, class Model, bool Congruent>
TWANG_INLINE void pair_block(const Geometry<Element, Congruent>& geometry,
                             const TangentTables<Element>& tables,
                             int a,
                             int b,
                             double* block) {
  Mat3 K = {};
  Vec diagonal = {};
  for (int g = 0; g < Element::points; ++g) {
    typename Geometry<Element, Congruent>::Scalar dN[3];
    for (int j = 0; j < 3; ++j) geometry.gradient(g, b, j, dN[j]);
    const Vec* stress_dN = tables.stress_dN[a][g];
    diagonal += stress_dN[0] * dN[0] + stress_dN[1] * dN[1] + stress_dN[2] * dN[2];
    const Vec* p_b = tables.p[b][g];
    const Vec* first_p_a = tables.first_p[a][g];
    const Vec* second_p_a = tables.second_p[a][g];
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) K.m[i][k] += p_b[i] * first_p_a[k] + second_p_a[i] * p_b[k];
    }
    if constexpr (Model::has_left_tensor) {
      typename Geometry<Element, Congruent>::Scalar dN_a[3];
      for (int j = 0; j < 3; ++j) geometry.gradient(g, a, j, dN_a[j]);
      const auto dot = dN_a[0] * dN[0] + dN_a[1] * dN[1] + dN_a[2] * dN[2];
      for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) K.m[i][k] += tables.left[g].m[i][k] * dot;
      }
    }
  }
  for (int k = 0; k < 3; ++k) {
    K.m[k][k] += diagonal;
    for (int i = 0; i < 3; ++i) store(block + (3 * k + i) * kLanes, K.m[i][k]);
  }
}

template <class Element, class Model, bool Congruent>
void tangent_kernel(const ElementBatch& batch, double* result) {
  const Geometry<Element, Congruent> geometry{batch.geometry.gradients, batch.geometry.weights};
  TangentTables<Element> tables;
  fill_tables<Element, Model, Congruent>(geometry, batch, tables);
  for (int a = 0; a < Element::nodes; ++a) {
    for (int b = 0; b <= a; ++b) {
      pair_block<Element, Model, Congruent>(
          geometry, tables, a, b, result + (a * (a + 1) / 2 + b) * 9 * kLanes);
    }
  }
}

#include "fem/detail/element_dispatch_impl.hpp"

}  // namespace

ElementKernels kernels(ElementKind kind, ConstitutiveModel model) {
  if (kind == ElementKind::Hex8) return kernels_of<Hex8>(model);
  return kind == ElementKind::Hex20 ? kernels_of<Hex20>(model) : kernels_of<Hex8e>(model);
}

}  // namespace twang::TWANG_KERNEL_NAMESPACE
