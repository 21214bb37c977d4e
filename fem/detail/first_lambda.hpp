// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/elastic_body.hpp"

namespace twang {

/// Rough size of the first elastic eigenvalue: a free beam as long as the body is large and as
/// thick as twice its volume over its surface [1/s²].
[[nodiscard]] double estimate_first_lambda(const ElasticBody& body);

}  // namespace twang
