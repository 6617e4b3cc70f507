// Plans the work of a run that several processes share. Afterwards an ordinary run (ground_run.hpp) takes in the
// results of the tasks, and computes what is still missing.
#pragma once

#include "sim/ground/ground_run.hpp"
#include "sim/ground/tasks/work_package.hpp"

namespace ilp::ground {

/// Takes in new files and the results of earlier tasks, and writes packages (tasks/work_plan.hpp) for at most `tasks`
/// tasks. To be called for the kinds quick_looks, tiles and finish in this order; computes itself what the tasks of an
/// earlier kind have not done. Returns the number of packages; 0 if nothing is to do. Throws as run_ground does.
std::size_t plan_work(const GroundOptions& options, tasks::WorkKind kind, std::size_t tasks, std::ostream& messages);

}  // namespace ilp::ground
