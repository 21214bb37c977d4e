// SPDX-License-Identifier: GPL-3.0-or-later
// Included by one source file for each instruction set, which defines TWANG_KERNEL_NAMESPACE. No
// other header's inline functions are used here: compiled for one machine they could end up on
// another.
#include "fem/detail/voxel_kernels.hpp"

#ifndef TWANG_KERNEL_NAMESPACE
#error "TWANG_KERNEL_NAMESPACE must be defined by the file that includes this"
#endif

namespace twang::TWANG_KERNEL_NAMESPACE {
namespace {

#define TWANG_INLINE inline __attribute__((always_inline))

template <class Real>
struct VectorOf;
template <>
struct VectorOf<double> {
  typedef double Vec __attribute__((vector_size(32)));
  typedef double Unaligned __attribute__((vector_size(32), aligned(8), may_alias));
  typedef long long Mask __attribute__((vector_size(32)));
  static constexpr int width = 4;
  static constexpr Mask one_back = {3, 4, 5, 6};
};
template <>
struct VectorOf<float> {
  typedef float Vec __attribute__((vector_size(32)));
  typedef float Unaligned __attribute__((vector_size(32), aligned(4), may_alias));
  typedef int Mask __attribute__((vector_size(32)));
  static constexpr int width = 8;
  static constexpr Mask one_back = {7, 8, 9, 10, 11, 12, 13, 14};
};

template <class Real>
TWANG_INLINE void load(const Real* from, typename VectorOf<Real>::Vec& value) {
  value = *reinterpret_cast<const typename VectorOf<Real>::Unaligned*>(from);
}
template <class Real>
TWANG_INLINE void store(Real* to, const typename VectorOf<Real>::Vec& value) {
  *reinterpret_cast<typename VectorOf<Real>::Unaligned*>(to) = value;
}

/// Coefficients of a batch of cells.
template <class Vec>
struct Moduli {
  Vec mu, lambda, mass;
};

/// 1, x, xy and xyz squared, averaged over [-1, 1]³, by the number of factors.
template <class Real>
inline constexpr Real kSquare[4] = {Real(1.0), Real(1.0 / 3.0), Real(1.0 / 9.0), Real(1.0 / 27.0)};

/// Keeps 0 / 0 away where a cell has no stiffness.
template <class Real>
inline constexpr Real kTiny = Real(1e-37);

/// Values at the nodes to eight times the coefficients of 1, x, y, xy, z, xz, yz, xyz (a bit for
/// each axis, as nodes are numbered).
template <class Vec>
TWANG_INLINE void coefficients_from_nodes(Vec* t) {
  for (int bit = 1; bit < 8; bit *= 2) {
    for (int n = 0; n < 8; ++n) {
      if ((n & bit) != 0) continue;
      const Vec low = t[n];
      const Vec high = t[n | bit];
      t[n] = low + high;
      t[n | bit] = high - low;
    }
  }
}

/// The transpose of that.
template <class Vec>
TWANG_INLINE void nodes_from_coefficients(Vec* t) {
  for (int bit = 1; bit < 8; bit *= 2) {
    for (int n = 0; n < 8; ++n) {
      if ((n & bit) != 0) continue;
      const Vec sum = t[n];
      const Vec difference = t[n | bit];
      t[n] = sum - difference;
      t[n | bit] = sum + difference;
    }
  }
}

/// Derivatives of the energy of one pair of normal strains and their lambda; e becomes the stress.
template <class Vec>
TWANG_INLINE void normal_pair(const Vec& two_mu, const Vec& lambda, Vec& e0, Vec& e1) {
  const Vec pressure = lambda * (e0 + e1);
  e0 = two_mu * e0 + pressure;
  e1 = two_mu * e1 + pressure;
}

/// Stiffness between the coefficients t[component][function], added to f. The strains that are
/// constant, linear (by x, y, z) and bilinear (yz, zx, xy) are orthogonal to each other:
///
///     e_aa = g_a ∂_a u_a,  γ_ab = g_b ∂_b u_a + g_a ∂_a u_b,   g = 2 / cell size
template <class Real, bool Enhanced, class Vec>
TWANG_INLINE void add_stiffness(const CellConstants<Real>& constants,
                                const Moduli<Vec>& moduli,
                                const Vec (*t)[8],
                                Vec (*f)[8]) {
  const Real* g = constants.per_half;
  const Vec two_mu = moduli.mu + moduli.mu;
  {
    Vec e[3];
    for (int a = 0; a < 3; ++a) e[a] = g[a] * t[a][1 << a];
    const Vec pressure = moduli.lambda * (e[0] + e[1] + e[2]);
    for (int a = 0; a < 3; ++a) f[a][1 << a] += g[a] * (two_mu * e[a] + pressure);
    for (int a = 0; a < 3; ++a) {
      const int b = (a + 1) % 3;
      const Vec shear = moduli.mu * (g[b] * t[a][1 << b] + g[a] * t[b][1 << a]);
      f[a][1 << b] += g[b] * shear;
      f[b][1 << a] += g[a] * shear;
    }
  }
  // Linear along axis l; a and b are the other two.
  const Vec mu = moduli.mu * kSquare<Real>[1];
  Vec lambda = moduli.lambda * kSquare<Real>[1];
  if constexpr (Enhanced) lambda = lambda * two_mu / (moduli.lambda + two_mu + kTiny<Real>);
  for (int l = 0; l < 3; ++l) {
    const int a = (l + 1) % 3;
    const int b = (l + 2) % 3;
    const int la = (1 << l) | (1 << a);
    const int lb = (1 << l) | (1 << b);
    Vec e_a = g[a] * t[a][la];
    Vec e_b = g[b] * t[b][lb];
    normal_pair(Vec(mu + mu), lambda, e_a, e_b);
    f[a][la] += g[a] * e_a;
    f[b][lb] += g[b] * e_b;
    const Vec shear = mu * (g[b] * t[a][lb] + g[a] * t[b][la]);
    f[a][lb] += g[b] * shear;
    f[b][la] += g[a] * shear;
    if constexpr (!Enhanced) {
      f[l][la] += (g[a] * g[a]) * (mu * t[l][la]);
      f[l][lb] += (g[b] * g[b]) * (mu * t[l][lb]);
    }
  }
  for (int l = 0; l < 3; ++l) {
    const Real own = g[l] * g[l];
    const Real others = g[(l + 1) % 3] * g[(l + 1) % 3] + g[(l + 2) % 3] * g[(l + 2) % 3];
    const Vec stiff = Enhanced ? two_mu : Vec(two_mu + moduli.lambda);
    f[l][7] += kSquare<Real>[2] * (own * stiff + others * moduli.mu) * t[l][7];
  }
}

/// t[component][node] becomes A t.
template <class Real, bool Stiffness, bool Mass, bool Enhanced, class Vec>
TWANG_INLINE void multiply_cells(const CellConstants<Real>& constants,
                                 const Moduli<Vec>& moduli,
                                 Vec (*t)[8]) {
  Vec f[3][8];
  for (int a = 0; a < 3; ++a) {
    coefficients_from_nodes(t[a]);
    for (int m = 0; m < 8; ++m) {
      if constexpr (Mass) {
        f[a][m] = (kSquare<Real>[__builtin_popcount(m)] * moduli.mass) * t[a][m];
      } else {
        f[a][m] = Vec{};
      }
    }
  }
  if constexpr (Stiffness) add_stiffness<Real, Enhanced>(constants, moduli, t, f);
  for (int a = 0; a < 3; ++a) {
    nodes_from_coefficients(f[a]);
    for (int m = 0; m < 8; ++m) t[a][m] = f[a][m];
  }
}

template <class Real, bool Stiffness, bool Mass, class Vec>
TWANG_INLINE void load_moduli(const CellConstants<Real>& constants,
                              const Real* mu,
                              const Real* lambda,
                              const Real* mass,
                              Moduli<Vec>& moduli) {
  moduli = Moduli<Vec>{};
  if constexpr (Stiffness) {
    load(mu, moduli.mu);
    load(lambda, moduli.lambda);
    moduli.mu *= constants.scale;
    moduli.lambda *= constants.scale;
  }
  if constexpr (Mass) {
    load(mass, moduli.mass);
    moduli.mass *= constants.scale;
  }
}

/// The last cells of a row, fewer than a vector holds, with what those before leave to the first
/// node.
template <class Real, bool Stiffness, bool Mass, bool Enhanced, class Vec>
void add_last_cells(const CellConstants<Real>& constants,
                    const CellRow<Real>& row,
                    int first,
                    const Vec* carry) {
  constexpr int kWidth = VectorOf<Real>::width;
  const int rest = row.length - first;
  Real coefficients[3][kWidth] = {};
  for (int i = 0; i < kWidth; ++i) {
    // Copies of the last cell fill the vector up: 0 would divide by 0.
    const int from = first + (i < rest ? i : rest - 1);
    if constexpr (Stiffness) {
      coefficients[0][i] = row.mu[from];
      coefficients[1][i] = row.lambda[from];
    }
    if constexpr (Mass) coefficients[2][i] = row.mass[from];
  }
  Moduli<Vec> moduli;
  load_moduli<Real, Stiffness, Mass>(
      constants, coefficients[0], coefficients[1], coefficients[2], moduli);
  Vec t[3][8] = {};
  for (int a = 0; a < 3; ++a) {
    for (int n = 0; n < 8; ++n) {
      const Real* from = row.x[a][n >> 1] + first + (n & 1);
      for (int i = 0; i < rest; ++i) t[a][n][i] = from[i];
    }
  }
  multiply_cells<Real, Stiffness, Mass, Enhanced>(constants, moduli, t);
  for (int a = 0; a < 3; ++a) {
    for (int edge = 0; edge < 4; ++edge) {
      Real* to = row.y[a][edge] + first;
      to[0] += carry[4 * a + edge][kWidth - 1];
      for (int i = 0; i < rest; ++i) to[i] += t[a][2 * edge][i];
      for (int i = 0; i < rest; ++i) to[i + 1] += t[a][2 * edge + 1][i];
    }
  }
}

template <class Real, bool Stiffness, bool Mass, bool Enhanced>
void add_product(const CellConstants<Real>& constants, const CellRow<Real>& row) {
  using Vec = typename VectorOf<Real>::Vec;
  constexpr int kWidth = VectorOf<Real>::width;
  Vec carry[12] = {};  // what the cells before give to their right nodes
  int first = 0;
  for (; first + kWidth <= row.length; first += kWidth) {
    Moduli<Vec> moduli;
    load_moduli<Real, Stiffness, Mass>(
        constants, row.mu + first, row.lambda + first, row.mass + first, moduli);
    Vec t[3][8];
    for (int a = 0; a < 3; ++a) {
      for (int n = 0; n < 8; ++n) load(row.x[a][n >> 1] + first + (n & 1), t[a][n]);
    }
    multiply_cells<Real, Stiffness, Mass, Enhanced>(constants, moduli, t);
    for (int a = 0; a < 3; ++a) {
      for (int edge = 0; edge < 4; ++edge) {
        Real* to = row.y[a][edge] + first;
        Vec sum;
        load(to, sum);
        const Vec right = t[a][2 * edge + 1];
        sum += t[a][2 * edge] +
               __builtin_shuffle(carry[4 * a + edge], right, VectorOf<Real>::one_back);
        store(to, sum);
        carry[4 * a + edge] = right;
      }
    }
  }
  if (first < row.length) {
    add_last_cells<Real, Stiffness, Mass, Enhanced>(constants, row, first, carry);
    return;
  }
  for (int a = 0; a < 3; ++a) {
    for (int edge = 0; edge < 4; ++edge) {
      row.y[a][edge][first] += carry[4 * a + edge][kWidth - 1];
    }
  }
}

void add_dense(const DenseRow& row) {
  using Vec = VectorOf<float>::Vec;
  for (int i = 0; i < row.length; ++i) {
    const float* column = row.matrices + 576L * row.type[i];
    Vec sum[3] = {};
    for (int a = 0; a < 3; ++a) {
      for (int n = 0; n < 8; ++n, column += 24) {
        const float x = row.scale * row.x[a][n >> 1][i + (n & 1)];
        for (int b = 0; b < 3; ++b) {
          Vec values;
          load(column + 8 * b, values);
          sum[b] += values * x;
        }
      }
    }
    for (int b = 0; b < 3; ++b) {
      for (int n = 0; n < 8; ++n) row.y[b][n >> 1][i + (n & 1)] += sum[b][n];
    }
  }
}

template <class Real, bool Enhanced>
constexpr RowProducts<Real> row_products() {
  return {add_product<Real, true, true, Enhanced>,
          add_product<Real, true, false, Enhanced>,
          add_product<Real, false, true, Enhanced>};
}

}  // namespace

const VoxelKernels& kernels() {
  static constexpr VoxelKernels kKernels{row_products<double, false>(),
                                         row_products<double, true>(),
                                         row_products<float, false>(),
                                         row_products<float, true>(),
                                         add_dense};
  return kKernels;
}

}  // namespace twang::TWANG_KERNEL_NAMESPACE
