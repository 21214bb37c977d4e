// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// What nearly every file of the rooms includes, read once for all of them. Files still include what they use: they must
// compile with CMAKE_DISABLE_PRECOMPILE_HEADERS=ON.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
