#include <gtest/gtest.h>
#include "tools/sim/krl/interpreter.hpp"
#include "tools/sim/krl/load.hpp"
