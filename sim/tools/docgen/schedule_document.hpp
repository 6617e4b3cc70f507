// Generates the page of the schedule, its picture, and the tables of stages on the pages of the stages' folders.
#pragma once

#include <string>

namespace ilp::docgen {

/// Body of schedule.md, below its title.
std::string schedule_document();

/// A Mermaid flowchart of the imaging chain from capture clock to file delivery: which component wakes which other one,
/// and by which records. Commands and settings, which wake many components, are not drawn.
std::string schedule_picture();

/// The table of the stages that `page` describes.
std::string stages_of(const std::string& page);

}  // namespace ilp::docgen
