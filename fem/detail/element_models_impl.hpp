// SPDX-License-Identifier: GPL-3.0-or-later
// The constitutive models on vectors of displacement gradients H = F - I; part of
// element_kernels_impl.hpp, which includes it inside its namespace. Formulas: fem/constitutive.hpp,
// here arranged so that small displacements lose no digits.

/// What a quadrature point gives to the block of nodes a, b:
///
///     K_ab = (dN_a . S dN_b) I + (dN_a . dN_b) B + first p_b p_a' + second p_a p_b',  p_a = T dN_a
struct PointTangent {
  Mat3 T;
  Mat3 S;      ///< symmetric
  Mat3 B;      ///< symmetric; read of models with has_left_tensor alone
  Vec first;   ///< weight of p_b p_a'
  Vec second;  ///< weight of p_a p_b'
};

struct NeoHookean {
  static constexpr bool is_linear = false;
  static constexpr bool has_left_tensor = false;

  /// I1/2 - 3/2 - ln J = H:H / 2 - second - third - (ln J - (J - 1))
  static TWANG_INLINE void energy(const Vec& mu, const Vec& lambda, const Mat3& H, Vec& density) {
    Volume volume;
    volume_change(H, volume);
    Vec log_j, log_j_minus_x;
    log_one_plus(volume.j_minus_one, log_j, log_j_minus_x);
    Vec norm2 = {};
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) norm2 += H.m[i][j] * H.m[i][j];
    }
    density = mu * (0.5 * norm2 - volume.second - volume.third - log_j_minus_x) +
              0.5 * lambda * log_j * log_j;
    for (int lane = 0; lane < kLanes; ++lane) {
      if (!(volume.j_minus_one[lane] > -1.0)) density[lane] = __builtin_inf();
    }
  }

  /// mu (F - F^-T) + lambda ln J F^-T with F - F^-T = H + F^-T H'
  static TWANG_INLINE void stress(const Vec& mu, const Vec& lambda, const Mat3& H, Mat3& P) {
    Mat3 Q;
    Vec log_j;
    invert(H, Q, log_j);
    const Vec pressure = lambda * log_j;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const Vec product = Q.m[i][0] * H.m[j][0] + Q.m[i][1] * H.m[j][1] + Q.m[i][2] * H.m[j][2];
        P.m[i][j] = mu * (H.m[i][j] + product) + pressure * Q.m[i][j];
      }
    }
  }

  /// mu dF + (mu - lambda ln J) F^-T dF' F^-T + lambda tr(F^-1 dF) F^-T
  static TWANG_INLINE void differential(
      const Vec& mu, const Vec& lambda, const Mat3& H, const Mat3& dF, Mat3& dP) {
    Mat3 Q, turned, inner;
    Vec log_j;
    invert(H, Q, log_j);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        inner.m[i][j] = dF.m[0][i] * Q.m[0][j] + dF.m[1][i] * Q.m[1][j] + dF.m[2][i] * Q.m[2][j];
      }
    }
    multiply(Q, inner, turned);
    const Vec shear = mu - lambda * log_j;
    const Vec pressure = lambda * (inner.m[0][0] + inner.m[1][1] + inner.m[2][2]);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        dP.m[i][j] = mu * dF.m[i][j] + shear * turned.m[i][j] + pressure * Q.m[i][j];
      }
    }
  }

  static TWANG_INLINE void tangent(const Vec& mu,
                                   const Vec& lambda,
                                   const Mat3& H,
                                   PointTangent& point) {
    Vec log_j;
    invert(H, point.T, log_j);
    point.S = Mat3{};
    for (int i = 0; i < 3; ++i) point.S.m[i][i] = mu;
    point.first = mu - lambda * log_j;
    point.second = lambda;
  }
};

struct SaintVenantKirchhoff {
  static constexpr bool is_linear = false;
  static constexpr bool has_left_tensor = true;

  static TWANG_INLINE void energy(const Vec& mu, const Vec& lambda, const Mat3& H, Vec& density) {
    Mat3 E;
    green_strain(H, E);
    isotropic_energy(mu, lambda, E, density);
  }

  static TWANG_INLINE void stress(const Vec& mu, const Vec& lambda, const Mat3& H, Mat3& P) {
    Mat3 E, S, F;
    green_strain(H, E);
    isotropic_stress(mu, lambda, E, S);
    add_identity(H, F);
    multiply(F, S, P);
  }

  /// dF S + F dS
  static TWANG_INLINE void differential(
      const Vec& mu, const Vec& lambda, const Mat3& H, const Mat3& dF, Mat3& dP) {
    Mat3 E, S, F, dE, dS, first, second;
    green_strain(H, E);
    isotropic_stress(mu, lambda, E, S);
    add_identity(H, F);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        dE.m[i][j] =
            0.5 * (F.m[0][i] * dF.m[0][j] + F.m[1][i] * dF.m[1][j] + F.m[2][i] * dF.m[2][j] +
                   dF.m[0][i] * F.m[0][j] + dF.m[1][i] * F.m[1][j] + dF.m[2][i] * F.m[2][j]);
      }
    }
    isotropic_stress(mu, lambda, dE, dS);
    multiply(dF, S, first);
    multiply(F, dS, second);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) dP.m[i][j] = first.m[i][j] + second.m[i][j];
    }
  }

  static TWANG_INLINE void tangent(const Vec& mu,
                                   const Vec& lambda,
                                   const Mat3& H,
                                   PointTangent& point) {
    Mat3 E;
    green_strain(H, E);
    isotropic_stress(mu, lambda, E, point.S);
    add_identity(H, point.T);
    const Mat3& F = point.T;
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) {
        point.B.m[i][k] =
            mu * (F.m[i][0] * F.m[k][0] + F.m[i][1] * F.m[k][1] + F.m[i][2] * F.m[k][2]);
      }
    }
    point.first = mu;
    point.second = lambda;
  }
};

struct Linear {
  static constexpr bool is_linear = true;
  static constexpr bool has_left_tensor = false;

  static TWANG_INLINE void energy(const Vec& mu, const Vec& lambda, const Mat3& H, Vec& density) {
    Mat3 e;
    symmetric_part(H, e);
    isotropic_energy(mu, lambda, e, density);
  }

  static TWANG_INLINE void stress(const Vec& mu, const Vec& lambda, const Mat3& H, Mat3& P) {
    Mat3 e;
    symmetric_part(H, e);
    isotropic_stress(mu, lambda, e, P);
  }

  static TWANG_INLINE void differential(
      const Vec& mu, const Vec& lambda, const Mat3&, const Mat3& dF, Mat3& dP) {
    stress(mu, lambda, dF, dP);
  }

  static TWANG_INLINE void tangent(const Vec& mu,
                                   const Vec& lambda,
                                   const Mat3&,
                                   PointTangent& point) {
    point.T = Mat3{};
    point.S = Mat3{};
    for (int i = 0; i < 3; ++i) {
      point.T.m[i][i] += 1.0;
      point.S.m[i][i] = mu;
    }
    point.first = mu;
    point.second = lambda;
  }
};
