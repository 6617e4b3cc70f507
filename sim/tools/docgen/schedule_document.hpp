// The page of the schedule, its picture, and the tables of stages on the pages of the rooms.
#pragma once

#include <string>

namespace ilp::docgen {

std::string schedule_document();

/// A Mermaid flowchart: which component wakes which by what it writes. Only the imaging chain, from capture clock to
/// file delivery, is drawn; commands and settings, which wake many, are not.
std::string schedule_picture();

/// The table of the stages that have this page.
std::string stages_of(const std::string& page);

}  // namespace ilp::docgen
