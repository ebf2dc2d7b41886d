#pragma once

#include <span>
#include <string>

#include "core/judge/iso9283.hpp"
#include "proto/record/iso9283_document.hpp"

namespace truepose::tools {

/// Tables of AP and RP, and where they were measured of vAP and of the drift; mm and deg.
std::string iso9283_text(const Iso9283Result& result, std::span<const TestPoint> points,
                         record::Iso9283Frame frame);

}  // namespace truepose::tools
