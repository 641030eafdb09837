// The robot file as its people wrote it, with a few numbers of its drives replaced: comments, order and layout stay.
#pragma once

#include <map>
#include <string>

#include "host/joint_fit.hpp"

namespace armsight::host {

/// text: of a robot file that loads. The drives of these joints (from 0) get sign, counts_per_turn, gear, zero_rad and
/// commissioned: true. What comes out has been read again and says just that; throws ConfigError where it does not.
std::string with_commissioned(const std::string& text, const std::string& file_name,
                              const std::map<std::size_t, JointFit>& fits);

}  // namespace armsight::host
