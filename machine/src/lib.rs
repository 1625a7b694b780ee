//! What hosts load of a described machine: the functions of FMI 2.0 and 3.0, alike for every
//! machine. The packager puts this library into an archive under the machine's name and the
//! machine's file beside it; see `vibro_assembly_fmi`.

use vibro_assembly_fmi::Machine;

fmi_doors::export!(Machine);
