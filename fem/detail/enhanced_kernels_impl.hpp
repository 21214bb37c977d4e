// SPDX-License-Identifier: GPL-3.0-or-later
// hex8e: the kernels of an element with eleven nodes, the last three being internal modes,
// condensed to eight; part of element_kernels_impl.hpp, which includes it inside its namespace.
//
//     W_e(u) = min over alpha of W(u, alpha),   K_e = K_uu - K_ua K_aa^-1 K_au
//
// The minimum is found by Newton's method from alpha = 0, so that nothing is kept between calls and
// all is a function of u alone. Where it is not found (K_aa indefinite: the element's strain has
// lost stability) the element counts as inverted.

constexpr int kInner = 9;
constexpr int kOuter = 24;
constexpr int kMaxInnerSteps = 25;
constexpr int kMaxHalvings = 12;
/// Newton's decrement over mu times volume, a squared strain, below which a step is the last: what
/// remains is its square.
constexpr double kLastDecrement = 1e-20;
/// Above it, strains of a percent, a step must not raise the energy.
constexpr double kCheckedDecrement = 1e-4;

/// All degrees of freedom of the element, [node][xyz][lane], and the factor of K_aa.
struct Inner {
  double z[(kOuter + kInner) * kLanes];
  Vec L[kInner][kInner];  ///< lower triangle
};

/// L L' = A in place; not a number where A is not positive definite.
TWANG_INLINE void factorize_inner(Vec (*A)[kInner]) {
  for (int j = 0; j < kInner; ++j) {
    for (int k = 0; k < j; ++k) A[j][j] -= A[j][k] * A[j][k];
    for (int lane = 0; lane < kLanes; ++lane) {
      const double pivot = A[j][j][lane];
      A[j][j][lane] = pivot > 0.0 ? sqrt(pivot) : __builtin_nan("");
    }
    const Vec inverse = 1.0 / A[j][j];
    for (int i = j + 1; i < kInner; ++i) {
      for (int k = 0; k < j; ++k) A[i][j] -= A[i][k] * A[j][k];
      A[i][j] *= inverse;
    }
  }
}

/// x = L^-1 x
TWANG_INLINE void solve_lower(const Vec (*L)[kInner], Vec* x) {
  for (int i = 0; i < kInner; ++i) {
    for (int k = 0; k < i; ++k) x[i] -= L[i][k] * x[k];
    x[i] /= L[i][i];
  }
}
/// x = L^-T x
TWANG_INLINE void solve_upper(const Vec (*L)[kInner], Vec* x) {
  for (int i = kInner - 1; i >= 0; --i) {
    for (int k = i + 1; k < kInner; ++k) x[i] -= L[k][i] * x[k];
    x[i] /= L[i][i];
  }
}

/// K_aa at inner.z, factorized.
template <class Model, bool Congruent>
void factorize_at(const ElementBatch& batch, Inner& inner) {
  const Geometry<Hex8e, Congruent> geometry{batch.geometry.gradients, batch.geometry.weights};
  ElementBatch all = batch;
  all.u = inner.z;
  TangentTables<Hex8e> tables;
  fill_tables<Hex8e, Model, Congruent>(geometry, all, tables);
  for (int p = 0; p < 3; ++p) {
    for (int q = 0; q <= p; ++q) {
      double block[9 * kLanes];
      pair_block<Hex8e, Model, Congruent>(geometry, tables, 8 + p, 8 + q, block);
      for (int k = 0; k < 3; ++k) {
        for (int i = 0; i < 3; ++i)
          load(block + (3 * k + i) * kLanes, inner.L[3 * p + i][3 * q + k]);
      }
    }
  }
  factorize_inner(inner.L);
}

TWANG_INLINE void move_inner(const double* from, const Vec* step, const Vec& length, double* to) {
  for (int i = 0; i < kInner; ++i) {
    Vec value;
    load(from + (kOuter + i) * kLanes, value);
    // Lanes that stand still may have a step that is no number.
    for (int lane = 0; lane < kLanes; ++lane) {
      if (length[lane] != 0.0) value[lane] += length[lane] * step[i][lane];
    }
    store(to + (kOuter + i) * kLanes, value);
  }
}

/// Halves the length of steps that would raise the energy.
template <class Model, bool Congruent>
void shorten(const ElementBatch& batch,
             const Inner& inner,
             const Vec* step,
             const Vec& checked,
             Vec& length) {
  ElementBatch all = batch;
  all.u = inner.z;
  double before[kLanes], after[kLanes];
  energy_kernel<Hex8e, Model, Congruent>(all, before);
  double trial[(kOuter + kInner) * kLanes];
  for (int i = 0; i < kOuter * kLanes; ++i) trial[i] = inner.z[i];
  all.u = trial;
  for (int k = 0; k < kMaxHalvings; ++k) {
    move_inner(inner.z, step, length, trial);
    energy_kernel<Hex8e, Model, Congruent>(all, after);
    bool good = true;
    for (int lane = 0; lane < kLanes; ++lane) {
      if (checked[lane] == 0.0 || after[lane] <= before[lane]) continue;
      length[lane] *= 0.5;
      good = false;
    }
    if (good) return;
  }
}

/// inner.z = (u, alpha) with alpha at the minimum, not a number where there is none.
template <class Model, bool Congruent>
void find_inner(const ElementBatch& batch, Inner& inner) {
  const Geometry<Hex8e, Congruent> geometry{batch.geometry.gradients, batch.geometry.weights};
  for (int i = 0; i < kOuter * kLanes; ++i) inner.z[i] = batch.u[i];
  for (int i = kOuter * kLanes; i < (kOuter + kInner) * kLanes; ++i) inner.z[i] = 0.0;
  ElementBatch all = batch;
  all.u = inner.z;
  Vec scale = {};
  for (int g = 0; g < Hex8e::split; ++g) {
    typename Geometry<Hex8e, Congruent>::Scalar weight;
    geometry.weight(g, weight);
    scale += weight;
  }
  Vec mu;
  load(batch.mu, mu);
  scale *= mu;
  bool done[kLanes] = {};
  for (int k = 0; k < kMaxInnerSteps; ++k) {
    double force[(kOuter + kInner) * kLanes];
    force_kernel<Hex8e, Model, Congruent>(all, force);
    if (k == 0 || !Model::is_linear) factorize_at<Model, Congruent>(batch, inner);
    Vec step[kInner];
    Vec decrement = {};
    for (int i = 0; i < kInner; ++i) {
      load(force + (kOuter + i) * kLanes, step[i]);
      step[i] = -step[i];
    }
    solve_lower(inner.L, step);
    for (int i = 0; i < kInner; ++i) decrement += step[i] * step[i];
    solve_upper(inner.L, step);
    Vec length = {}, checked = {};
    bool some_left = false;
    for (int lane = 0; lane < kLanes; ++lane) {
      length[lane] = done[lane] ? 0.0 : 1.0;
      checked[lane] = !done[lane] && decrement[lane] > kCheckedDecrement * scale[lane] ? 1.0 : 0.0;
      const bool last = Model::is_linear || !(decrement[lane] > kLastDecrement * scale[lane]);
      done[lane] = done[lane] || last;
      some_left = some_left || !done[lane];
    }
    if (some_left && !Model::is_linear)
      shorten<Model, Congruent>(batch, inner, step, checked, length);
    move_inner(inner.z, step, length, inner.z);
    if (!some_left) return;
  }
  for (int lane = 0; lane < kLanes; ++lane) {
    if (!done[lane]) inner.z[kOuter * kLanes + lane] = __builtin_nan("");
  }
}

/// As find_inner, with the factor of K_aa there. A linear element's is the same everywhere.
template <class Model, bool Congruent>
void factorize_at_minimum(const ElementBatch& batch, Inner& inner) {
  if constexpr (Model::is_linear) {
    for (double& value : inner.z) value = 0.0;
  } else {
    find_inner<Model, Congruent>(batch, inner);
  }
  factorize_at<Model, Congruent>(batch, inner);
}

template <class Model, bool Congruent>
void condensed_energy(const ElementBatch& batch, double* result) {
  Inner inner;
  find_inner<Model, Congruent>(batch, inner);
  ElementBatch all = batch;
  all.u = inner.z;
  energy_kernel<Hex8e, Model, Congruent>(all, result);
  for (int lane = 0; lane < kLanes; ++lane) {
    if (result[lane] != result[lane]) result[lane] = __builtin_inf();
  }
}

template <class Model, bool Congruent>
void condensed_force(const ElementBatch& batch, double* result) {
  Inner inner;
  find_inner<Model, Congruent>(batch, inner);
  ElementBatch all = batch;
  all.u = inner.z;
  double force[(kOuter + kInner) * kLanes];
  force_kernel<Hex8e, Model, Congruent>(all, force);
  for (int i = 0; i < kOuter * kLanes; ++i) result[i] = force[i];
}

template <class Model, bool Congruent>
void condensed_product(const ElementBatch& batch, double* result) {
  Inner inner;
  factorize_at_minimum<Model, Congruent>(batch, inner);
  double w[(kOuter + kInner) * kLanes], product[(kOuter + kInner) * kLanes];
  for (int i = 0; i < kOuter * kLanes; ++i) w[i] = batch.w[i];
  for (int i = kOuter * kLanes; i < (kOuter + kInner) * kLanes; ++i) w[i] = 0.0;
  ElementBatch all = batch;
  all.u = inner.z;
  all.w = w;
  product_kernel<Hex8e, Model, Congruent>(all, product);
  Vec alpha[kInner];
  for (int i = 0; i < kInner; ++i) {
    load(product + (kOuter + i) * kLanes, alpha[i]);
    alpha[i] = -alpha[i];
  }
  solve_lower(inner.L, alpha);
  solve_upper(inner.L, alpha);
  for (int i = 0; i < kInner; ++i) store(w + (kOuter + i) * kLanes, alpha[i]);
  product_kernel<Hex8e, Model, Congruent>(all, product);
  for (int i = 0; i < kOuter * kLanes; ++i) result[i] = product[i];
}

template <class Model, bool Congruent>
void condensed_tangent(const ElementBatch& batch, double* result) {
  Inner inner;
  factorize_at_minimum<Model, Congruent>(batch, inner);
  ElementBatch all = batch;
  all.u = inner.z;
  constexpr int kPairs = Hex8e::nodes * (Hex8e::nodes + 1) / 2;
  double tangent[kPairs * 9 * kLanes];
  tangent_kernel<Hex8e, Model, Congruent>(all, tangent);
  // Columns of L^-1 K_au.
  Vec Y[kOuter][kInner];
  for (int b = 0; b < 8; ++b) {
    for (int k = 0; k < 3; ++k) {
      for (int p = 0; p < 3; ++p) {
        const int a = 8 + p;
        const double* block = tangent + (a * (a + 1) / 2 + b) * 9 * kLanes;
        for (int i = 0; i < 3; ++i) load(block + (3 * k + i) * kLanes, Y[3 * b + k][3 * p + i]);
      }
      solve_lower(inner.L, Y[3 * b + k]);
    }
  }
  for (int a = 0; a < 8; ++a) {
    for (int b = 0; b <= a; ++b) {
      const int at = (a * (a + 1) / 2 + b) * 9 * kLanes;
      for (int k = 0; k < 3; ++k) {
        for (int i = 0; i < 3; ++i) {
          Vec value;
          load(tangent + at + (3 * k + i) * kLanes, value);
          for (int m = 0; m < kInner; ++m) value -= Y[3 * a + i][m] * Y[3 * b + k][m];
          store(result + at + (3 * k + i) * kLanes, value);
        }
      }
    }
  }
}

template <class Model>
ElementKernels condensed_kernels_of() {
  return {
      [](const ElementBatch& batch, double* result) {
        if (batch.geometry.congruent) return condensed_energy<Model, true>(batch, result);
        condensed_energy<Model, false>(batch, result);
      },
      [](const ElementBatch& batch, double* result) {
        if (batch.geometry.congruent) return condensed_force<Model, true>(batch, result);
        condensed_force<Model, false>(batch, result);
      },
      [](const ElementBatch& batch, double* result) {
        if (batch.geometry.congruent) return condensed_product<Model, true>(batch, result);
        condensed_product<Model, false>(batch, result);
      },
      [](const ElementBatch& batch, double* result) {
        if (batch.geometry.congruent) return condensed_tangent<Model, true>(batch, result);
        condensed_tangent<Model, false>(batch, result);
      },
  };
}
