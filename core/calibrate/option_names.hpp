#pragma once

#include <array>

#include "core/choices.hpp"
#include "core/data/measurement.hpp"
#include "core/named.hpp"

namespace truepose {

inline constexpr std::array kFieldNames{
    Named{"none", FieldUse::None},
    Named{"auto", FieldUse::Auto},
    Named{"gp", FieldUse::Always},
};
inline constexpr std::array kLossNames{
    Named{"outlier-rejection", Loss::OutlierRejection},
    Named{"squared", Loss::Squared},
    Named{"huber", Loss::Huber},
    Named{"igg3", Loss::Igg3},
    Named{"tukey", Loss::Tukey},
};
inline constexpr std::array kThermalNames{
    Named{"none", ThermalUse::Off},
    Named{"auto", ThermalUse::Auto},
    Named{"temperatures", ThermalUse::Temperatures},
    Named{"time", ThermalUse::Time},
};
/// Whether joint deviations are looked for.
inline constexpr std::array kNoneOrAuto{Named{"none", false}, Named{"auto", true}};
inline constexpr std::array kPoseSetNames{
    Named{"identify", PoseSet::Identify},
    Named{"validate", PoseSet::Validate},
};
inline constexpr std::array kPriorNames{
    Named{"auto", PriorUse::Auto},
    Named{"off", PriorUse::Off},
    Named{"on", PriorUse::On},
};

}  // namespace truepose
