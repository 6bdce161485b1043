// Dawn: refuses it: expected ';' for variable declaration
@fragment fn fs() {
    let a = 1.0lf;
}
