// Dawn: refuses it: expected ';' for variable declaration
// Umbrage: the suffix `lf` of a 64-bit number is none of WGSL's, and what some devices offer beyond it modules cannot ask for
@fragment fn fs() {
    let a = 1.0lf;
}
