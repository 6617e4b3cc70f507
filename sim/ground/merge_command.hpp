// ilp-ground merge OUTBOX --out DIR ...: computes the results of ilp-ground in tasks on several processors or machines.
#pragma once

namespace ilp::ground {

/// Replaces the process by the script that runs tasks (sim/tools/cluster/merge.py). The script is searched beside this
/// program, then where the package installs it (../share), then in the sources whose build folder has this program.
/// `argv[1]` is "merge". Returns only if the script cannot be started, with exit status 2.
int merge_main(int argc, char** argv);

}  // namespace ilp::ground
