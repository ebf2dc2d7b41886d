#pragma once

#include "tools/sim/krl/type.hpp"

namespace truepose::sim::krl {

/// The components of a structure that another has by the same name; the others are not set.
Value reshaped(const Value& value, const Type& from, const Type& to, const Types& types);

/// The geometric operator: `right`, which is given in `left`, seen from outside. All but the pose is that of
/// `right`. X, Y, Z in mm, A, B, C in deg: Rz(A) Ry(B) Rx(C). Throws Fault: a component of a pose that is not
/// set.
Value composed(const Value& left, const Type& left_type, const Value& right, const Type& right_type,
               const Types& types);

/// INV_POS. Throws Fault: a component of the pose that is not set.
Value inverse_of(const Value& value, const Type& type, const Types& types);

}  // namespace truepose::sim::krl
