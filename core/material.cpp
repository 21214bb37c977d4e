// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/material.hpp"

#include <cmath>

namespace twang {

double UncertaintyBudget::total() const {
  double sum = 0.0;
  for (const double part :
       {statistical, repeats, mesh, clock, dimension, density, poissons_ratio}) {
    sum += part * part;
  }
  return std::sqrt(sum);
}

}  // namespace twang
