// Rules for the sources of the page and for its tests. Prettier decides on form.
import eslint from "typescript-eslint";

const vague = ["found", "one", "given", "made", "held", "asked"];

export default eslint.config(
  { ignores: ["**/node_modules/"] },
  eslint.configs.recommended,
  {
    rules: {
      "id-denylist": ["error", ...vague],
      "max-len": ["error", { code: 120, ignoreTemplateLiterals: true, ignoreRegExpLiterals: true }],
      "no-constant-binary-expression": "error",
      "object-shorthand": "error",
      eqeqeq: "error",
    },
  },
  {
    files: ["web/src/**/*.ts"],
    languageOptions: { parserOptions: { projectService: true, tsconfigRootDir: import.meta.dirname } },
    rules: {
      "@typescript-eslint/await-thenable": "error",
      "@typescript-eslint/explicit-function-return-type": [
        "error",
        { allowExpressions: true, allowTypedFunctionExpressions: true },
      ],
      "@typescript-eslint/no-floating-promises": "error",
      "@typescript-eslint/no-misused-promises": "error",
      "@typescript-eslint/no-unnecessary-type-assertion": "error",
      "@typescript-eslint/switch-exhaustiveness-check": "error",
    },
  },
);
