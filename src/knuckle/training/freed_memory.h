// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace knuckle {

/// Keeps what is freed for the next allocation. The paper's networks take and free gradients of 200 MB in
/// each step; glibc would give these back to the system, and faulting their pages in again would take a third
/// of the time.
void keep_freed_memory();

}  // namespace knuckle
