#pragma once

#include "core/kernels/kernels.hpp"

namespace truepose::kernels {

/// best() is that of another instruction set from now on: for who compares them. Not while others compute.
/// @param isa  available
void use(Isa isa);

}  // namespace truepose::kernels
